// Select triangles: finds the visible triangles of a slab and their regions, in vector code.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "gp_firmware/geometry/bin.hpp"
#include "gp_firmware/render/region_programs.hpp"
#include "isa/contract/vector_target.hpp"

namespace pxpl5::gp {

/// Triangles with boxes of at most this many pixels are tested for a covered pixel center. Most
/// triangles of a fine surface cover none, and testing them is cheaper than sending them.
inline constexpr int searched_px = 4;

/// A slab of one surface after transform().
struct ScreenSlab {
    std::span<const std::uint32_t> indices;  ///< 3 per triangle.
    const GridVertex* vertices = nullptr;
    const std::uint32_t* outside = nullptr;  ///< Outside bits per vertex; null if all are 0.
    std::uint32_t first_corner = 0;          ///< Number of the first vertex among the corners.
    std::uint32_t surface_word = 0;
    bool cull_back = false;
};

/// Consecutive triangles of a slab.
struct Selection {
    static constexpr std::size_t size = 64;

    // Values of `regions` besides region numbers:
    static constexpr std::uint32_t many_regions = 0xFFFFFFFF;  ///< All regions that it touches.
    /// The triangle must be clipped or is too large for vector code, which has not examined it.
    static constexpr std::uint32_t by_itself = 0xFFFFFFFE;

    std::uint64_t chosen = 0;  ///< Bit i: triangle i may be visible, and its fields are set.
    alignas(64) std::array<NamedTriangle, size> triangles;
    alignas(64) std::array<std::uint32_t, size> regions;
};

/// Examines the slab's triangles from `first` on, at most Selection::size of them. Omits invisible
/// triangles: without area, facing away, covering no pixel center (up to searched_px), outside of
/// the picture or of one plane.
///
/// first  A multiple of Selection::size.
using SelectTriangles = void (*)(const ScreenSlab& slab, const RegionGrid& grid, std::size_t first,
                                 Selection& selection);

/// Returns the function for a target. All targets give the same bits.
SelectTriangles select_triangles(VectorTarget target = isa::process_target());

}  // namespace pxpl5::gp
