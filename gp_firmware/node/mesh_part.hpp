// Mesh part: the message that hands over one GP's part of a surface's mesh.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "gp_firmware/render/frame_drawing.hpp"
#include "ringbus/message.hpp"

namespace pxpl5::gp {

/// Builds a MeshPart slab by slab.
class MeshPartBuilder {
  public:
    /// origins  Whether add() receives origins.
    /// Throws   bus::NodeFault if the surface is larger than a message may be.
    MeshPartBuilder(std::uint16_t surface, const HeldSurface& held, bool origins);
    /// origins  One per triangle, or empty.
    void add(const SlabMesh& mesh, std::span<const Origin> origins);
    bus::Payload finish();

  private:
    flatbuffers::FlatBufferBuilder builder_;
    std::vector<flatbuffers::Offset<bus::schema::SlabMesh>> slabs_;
    std::uint16_t surface_;
    std::uint32_t revision_;
    bool origins_;
};

}  // namespace pxpl5::gp
