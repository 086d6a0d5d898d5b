// Puts the GPs' blocks of one simplified surface together into one mesh.
#pragma once

#include <cstdint>
#include <vector>

#include "host/surface/volume_grid.hpp"
#include "host/surface/welded_mesh.hpp"
#include "ringbus/message.hpp"

namespace pxpl5::host {

/// A simplified surface.
struct SimplifiedMesh {
    WeldedMesh mesh;      ///< `slabs` has one entry per block, with the block's first slab.
    double moved_mm = 0;  ///< No point is farther from the exact surface.
};

/// Keeps the messages as they come and welds at the end.
class BlockGather {
  public:
    /// The simplified mesh that is gathered: a surface of the volume with nz slices.
    struct Wanted {
        std::uint16_t surface = 0;
        std::uint32_t revision = 0;
        int detail = 1;
        int nz = 0;
    };
    explicit BlockGather(const Wanted& wanted);

    /// Takes the blocks of a MeshPart; the message's bytes are kept alive, not copied.
    /// message  Of kind MeshPart (asserted), its ranges checked.
    /// Throws   RequestError naming both values for another surface, revision or detail, for a slab
    ///          that begins no block of the volume, and for a block that came before.
    void add(const bus::Message& message);

    /// Welds vertices by their keys and sorts them. The messages are given up.
    /// Throws   RequestError for a block that is missing, and where two blocks do not agree on a
    ///          vertex.
    SimplifiedMesh finish();

  private:
    Wanted wanted_;
    double moved_mm_ = 0;
    std::vector<bus::Message> messages_;                ///< Own what blocks_ points into.
    std::vector<const bus::schema::SlabMesh*> blocks_;  ///< By number; null: has not come.
};

}  // namespace pxpl5::host
