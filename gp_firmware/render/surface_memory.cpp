#include "gp_firmware/render/surface_memory.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "gp_firmware/surface/marching_cubes.hpp"

namespace pxpl5::gp {

namespace {

/// Frees the spare capacity of a mesh.
void tighten(SlabMesh& mesh) {
    if (size_bytes(mesh) > tight_bytes(mesh)) {
        mesh = SlabMesh(mesh);
    }
}

/// Takes the lists out of a mesh, which is not charged.
void leave_out(SlabMesh& mesh) {
    SlabMesh sizes;
    sizes.slab = mesh.slab;
    sizes.counts = mesh.counts;
    sizes.left_out = size_of(mesh);
    mesh = std::move(sizes);
}

}  // namespace

std::size_t tight_bytes(const SlabMesh& mesh) {
    const MeshSize size = size_of(mesh);
    return size.vertices * (sizeof(Vertex) + sizeof(std::uint64_t)) +
           3 * size.triangles * sizeof(std::uint32_t);
}

void fit_into_memory(std::span<SlabMesh> slabs, std::size_t at, Surfaces& surfaces,
                     LocalMemory& memory) {
    SlabMesh& mesh = slabs[at];
    const auto fits = [&] { return size_bytes(mesh) <= memory.available_bytes(); };
    if (fits()) {
        return;
    }
    tighten(mesh);
    for (std::size_t older = at + 1; older < slabs.size() && !fits(); ++older) {
        memory.release(size_bytes(slabs[older]));
        slabs[older] = SlabMesh{};
    }
    for (auto held = surfaces.begin(); held != surfaces.end() && !fits(); ++held) {
        drop_simplified(held->second, memory);
    }
    for (std::size_t newer = 0; newer < at && !fits(); ++newer) {
        const std::size_t before = size_bytes(slabs[newer]);
        tighten(slabs[newer]);
        memory.release(before - size_bytes(slabs[newer]));
    }
    if (!fits()) {
        leave_out(mesh);
    }
}

void drop(const SimplifiedSurface& simplified, LocalMemory& memory) {
    for (const SlabMesh& block : simplified.blocks) {
        memory.release(size_bytes(block));
    }
}

void drop_simplified(HeldSurface& surface, LocalMemory& memory) {
    for (const auto& [key, simplified] : surface.simplified) {
        drop(simplified, memory);
    }
    surface.simplified.clear();
}

void make_room(std::size_t bytes, int detail, Surfaces& surfaces, LocalMemory& memory) {
    std::size_t exact = 0;
    for (auto& [number, held] : surfaces) {
        for (auto at = held.simplified.begin();
             at != held.simplified.end() && bytes > memory.available_bytes();) {
            const auto next = std::next(at);
            if (at->first.first != detail) {
                drop(at->second, memory);
                held.simplified.erase(at);
            }
            at = next;
        }
        for (const SlabMesh& mesh : held.slabs) {
            exact += held.complete ? size_bytes(mesh) : 0;
        }
    }
    const bool suffices = bytes <= memory.available_bytes() + exact;
    for (auto& [number, held] : surfaces) {
        for (SlabMesh& mesh : held.slabs) {
            if (!suffices || bytes <= memory.available_bytes()) {
                return;
            }
            if (held.complete && size_bytes(mesh) > 0) {
                memory.release(size_bytes(mesh));
                leave_out(mesh);
            }
        }
    }
}

}  // namespace pxpl5::gp
