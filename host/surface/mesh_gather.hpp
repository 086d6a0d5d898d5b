// Puts the GPs' slabs of one surface together into one mesh.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "host/surface/pauses.hpp"
#include "host/surface/volume_grid.hpp"
#include "host/surface/welded_mesh.hpp"
#include "ringbus/message.hpp"

namespace pxpl5::host {

/// Keeps the messages as they come and welds at the end, so that no data is stored twice.
class MeshGather {
  public:
    /// grid  The grid of the surface's volume; nz gives the number of slabs.
    MeshGather(VolumeGrid grid, std::uint16_t surface, std::uint32_t revision);

    /// Takes the slabs of a MeshPart; the message's bytes are kept alive, not copied.
    /// message  Of kind MeshPart (asserted), its ranges checked.
    /// Throws   RequestError naming both values for another surface or revision, a slab that the
    ///          volume does not have or that came before, origins in some slabs only.
    void add(const bus::Message& message);

    /// Slabs that have not come yet.
    std::size_t missing() const;

    /// Welds vertices by their keys and sorts them. The messages are given up.
    /// Throws   RequestError naming slab and key: for a slab that is missing, a key that its slab
    ///          cannot have or has twice, and where two slabs do not agree on a vertex that they
    ///          share: one lacks it, or the bits differ. And what `pause` throws.
    WeldedMesh finish(const Pause& pause = {});

  private:
    VolumeGrid grid_;
    std::uint16_t surface_;
    std::uint32_t revision_;
    std::optional<bool> origins_;         ///< Whether the slabs tell triangles' cells.
    std::vector<bus::Message> messages_;  ///< Own what slabs_ points into.
    std::vector<const bus::schema::SlabMesh*> slabs_;
};

}  // namespace pxpl5::host
