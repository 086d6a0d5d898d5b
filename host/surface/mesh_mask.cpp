#include "host/surface/mesh_mask.hpp"

#include <algorithm>
#include <cassert>

namespace pxpl5::host {

bus::Payload mask_message(const WeldedMesh& mesh, const Shown& shown, std::uint16_t surface,
                          std::uint32_t revision) {
    assert(shown.size() == mesh.triangles.size());
    bus::schema::MaskSurfaceT mask;
    mask.surface = surface;
    mask.revision = revision;
    for (const SlabTriangles& slab : mesh.slabs) {
        const auto first = shown.begin() + static_cast<std::ptrdiff_t>(slab.first);
        const auto last = first + static_cast<std::ptrdiff_t>(slab.count);
        if (std::find(first, last, std::uint8_t{0}) == last) continue;
        auto part = std::make_unique<bus::schema::SlabMaskT>();
        part->slab = slab.slab;
        part->hidden.resize((slab.count + 7) / 8);
        for (std::size_t t = 0; t < slab.count; ++t) {
            if (shown[slab.first + t] != 0) continue;
            std::uint8_t& byte = part->hidden[t / 8];
            byte = static_cast<std::uint8_t>(byte | 1U << t % 8);
        }
        mask.slabs.push_back(std::move(part));
    }
    return bus::pack(mask);
}

}  // namespace pxpl5::host
