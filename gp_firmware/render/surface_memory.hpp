// The local memory of surfaces: what makes room for what, and which slabs are left out.
#pragma once

#include <cstddef>
#include <span>

#include "gp_firmware/hal/local_memory.hpp"
#include "gp_firmware/render/frame_drawing.hpp"

namespace pxpl5::gp {

/// Returns the bytes of a mesh without spare capacity. The mesh may be left out.
std::size_t tight_bytes(const SlabMesh& mesh);

inline bool is_left_out(const SlabMesh& mesh) {
    return mesh.left_out.has_value();
}

/// Makes the new mesh slabs[at], which is not charged yet, fit: without spare capacity, without the
/// meshes of the older revision behind it, without simplified surfaces, which are made again when
/// they are wanted, without spare capacity of the meshes before it, and at last without its lists.
void fit_into_memory(std::span<SlabMesh> slabs, std::size_t at, Surfaces& surfaces,
                     LocalMemory& memory);

/// Makes room for a simplified block of this detail: drops simplified surfaces of other details,
/// then leaves out exact slabs until `bytes` are free. Leaves out none if all do not suffice.
void make_room(std::size_t bytes, int detail, Surfaces& surfaces, LocalMemory& memory);

/// Returns the memory of a simplified surface.
void drop(const SimplifiedSurface& simplified, LocalMemory& memory);
/// Drops all simplified surfaces of a surface, because it has changed or the memory is needed.
void drop_simplified(HeldSurface& surface, LocalMemory& memory);

}  // namespace pxpl5::gp
