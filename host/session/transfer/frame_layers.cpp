#include "host/session/transfer/frame_layers.hpp"

#include <algorithm>
#include <cassert>

#include "isa/contract/region_layout.hpp"

namespace pxpl5::host {

namespace {

/// The surface field of a depth word: the index of an entry of drawn_surfaces() plus 1, or 0.
constexpr std::uint32_t surface_bits = (1U << isa::region::surface.width) - 1;

bool is_transparent(std::span<const Surface> surfaces, const Surface& surface) {
    return surface.visible && surface.opacity != full_opacity && !is_compared(surfaces, surface);
}

}  // namespace

std::size_t transparent_surfaces(std::span<const Surface> surfaces) {
    return static_cast<std::size_t>(std::ranges::count_if(
        surfaces, [&](const Surface& each) { return is_transparent(surfaces, each); }));
}

std::vector<Surface> without_transparent(std::span<const Surface> surfaces) {
    std::vector<Surface> kept(surfaces.begin(), surfaces.end());
    for (Surface& each : kept) {
        each.visible = each.visible && !is_transparent(surfaces, each);
    }
    return kept;
}

std::optional<SurfaceLayers> surface_layers(const Scene& scene, const Stage& stage) {
    if (transparent_surfaces(stage.surfaces) != 1) {
        return std::nullopt;
    }
    SurfaceLayers layers;
    layers.behind.assign(stage.surfaces.begin(), stage.surfaces.end());
    // Not removed: an invisible surface still counts as compared.
    Surface& front = *std::ranges::find_if(
        layers.behind, [&](const Surface& each) { return is_transparent(stage.surfaces, each); });
    layers.front = front;
    layers.front.opacity = full_opacity;
    layers.opacity = front.opacity;
    const std::vector<DrawnSurface> drawn = drawn_surfaces(scene, stage);
    layers.entries_before = static_cast<std::uint32_t>(
        std::ranges::find_if(
            drawn, [&](const DrawnSurface& each) { return each.surface->id == front.id; }) -
        drawn.begin());
    front.visible = false;
    return layers;
}

void put_in_front(std::span<const std::uint32_t> behind_rgba,
                  std::span<const std::uint32_t> behind_depths, std::span<std::uint32_t> rgba,
                  std::span<std::uint32_t> depths, std::uint32_t entries_before) {
    assert(behind_rgba.size() == rgba.size() && behind_depths.size() == rgba.size() &&
           depths.size() == rgba.size());
    // A word is a depth and, below, an index: the smaller word is seen. The picture behind has no
    // entry for the surface, so that its entry with the same index comes after the surface.
    for (std::size_t i = 0; i < rgba.size(); ++i) {
        const std::uint32_t front = (depths[i] & ~surface_bits) + entries_before;
        const std::uint32_t behind =
            (behind_depths[i] & surface_bits) == 0 ? UINT32_MAX : behind_depths[i] - 1;
        const bool is_seen = (depths[i] & surface_bits) != 0 && front <= behind;
        rgba[i] = is_seen ? rgba[i] : behind_rgba[i];
        depths[i] = is_seen ? depths[i] : 0;
    }
}

}  // namespace pxpl5::host
