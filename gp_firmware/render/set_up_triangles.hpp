// Set up triangles: the instruction words of many triangles of one region, in vectors.
#pragma once

#include <cstdint>
#include <span>

#include "gp_firmware/geometry/transform.hpp"
#include "isa/contract/vector_target.hpp"

namespace pxpl5::gp {

struct NamedTriangle;

/// The first pixel of a region in its view.
struct RegionPlace {
    int x0_px = 0, y0_px = 0;
};

/// Maximal extent in x and in y, in 1/16 px. Larger triangles exceed the vectors' 32-bit
/// arithmetic; draw_triangle() draws them.
inline constexpr int max_extent = 1 << 14;

/// Writes each triangle's isa::triangle::word_count words, with the same bits as plane_setup.hpp
/// and triangle_program.hpp on every target.
///
/// triangles  Triangles of positive determinant and extents below max_extent. Their bounding boxes
///            overlap the region, and none of their edges excludes it.
/// corners    The corners that the triangles refer to by number.
void set_up_triangles(std::span<const NamedTriangle> triangles, std::span<const GridVertex> corners,
                      RegionPlace place, std::uint32_t* words,
                      VectorTarget target = isa::process_target());

}  // namespace pxpl5::gp
