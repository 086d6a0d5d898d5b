// Mesh part: the message that hands over one GP's part of a surface's mesh.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "gp_firmware/render/frame_drawing.hpp"
#include "ringbus/message.hpp"

namespace pxpl5::gp {

/// One GP's part of a mesh.
struct MeshToSend {
    std::uint16_t surface = 0;
    std::uint32_t revision = 0;
    std::span<const SlabMesh> slabs;
    bool origins = false;  ///< Whether MeshPartBuilder::add() receives origins.
    int detail = 0;        ///< 0: exact.
    double moved_mm = 0;   ///< No point is farther from the exact surface.
};

/// Builds a MeshPart slab by slab.
class MeshPartBuilder {
  public:
    /// Throws bus::NodeFault if the mesh is larger than a message may be.
    explicit MeshPartBuilder(const MeshToSend& mesh);
    /// origins  One per triangle, or empty.
    void add(const SlabMesh& mesh, std::span<const Origin> origins);
    bus::Payload finish();

  private:
    flatbuffers::FlatBufferBuilder builder_;
    std::vector<flatbuffers::Offset<bus::schema::SlabMesh>> slabs_;
    MeshToSend all_;
};

}  // namespace pxpl5::gp
