// Triangle program: the instruction words of one triangle in one region.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "gp_firmware/render/plane_setup.hpp"

namespace pxpl5::gp {

/// An edge as a region's TREEgeZERO takes it.
struct RegionEdge {
    std::uint32_t width = 0;  ///< Bits; no value over the region overflows them.
    std::uint32_t a = 0, b = 0, c = 0;
};

/// Moves `edge` to the region whose first pixel is (x0, y0).
///
/// Returns  Nothing if no pixel of the region is inside. An edge that holds all over the region,
///          but with values of more than 32 bits, becomes 0 >= 0.
std::optional<RegionEdge> region_edge(const Edge& edge, int x0, int y0);

/// Writes the isa::triangle::word_count words of the shape in isa/triangle_shape.hpp.
///
/// surface_word  isa::triangle::surface_word() of the surface.
void write_triangle(const std::array<RegionEdge, 3>& edges, const AttributePlanes& planes, int x0,
                    int y0, std::uint32_t surface_word, std::uint32_t* words);

}  // namespace pxpl5::gp
