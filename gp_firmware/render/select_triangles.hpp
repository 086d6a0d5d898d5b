// Select triangles: which of a slab's triangles are drawn, and in which region, in vectors.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "gp_firmware/geometry/bin.hpp"
#include "gp_firmware/render/region_programs.hpp"
#include "isa/contract/vector_target.hpp"

namespace pxpl5::gp {

/// Boxes of at most this many pixels are searched: most triangles of a fine surface touch no
/// centre, and to find that out here is cheaper than to send them.
inline constexpr int searched_px = 4;

/// A slab of one surface after transform().
struct ScreenSlab {
    std::span<const std::uint32_t> indices;  ///< 3 per triangle.
    const GridVertex* vertices = nullptr;
    const std::uint32_t* outside = nullptr;  ///< Of each vertex; null if no vertex has a bit.
    std::uint32_t first_corner = 0;          ///< Number of the first vertex among the corners.
    std::uint32_t surface_word = 0;
    bool cull_back = false;
};

/// Some triangles of a slab, in their order.
struct Selection {
    static constexpr std::size_t size = 64;

    // Instead of a region:
    static constexpr std::uint32_t many_regions = 0xFFFFFFFF;  ///< Whichever its edges let it in.
    /// It is to be clipped or too large for vectors: nothing is known about it yet.
    static constexpr std::uint32_t by_itself = 0xFFFFFFFE;

    std::uint64_t chosen = 0;  ///< Bit i: triangle i may be drawn, and its fields below are set.
    alignas(64) std::array<NamedTriangle, size> triangles;
    alignas(64) std::array<std::uint32_t, size> regions;
};

/// Looks at the slab's triangles from `first` on, Selection::size of them or as many as there are.
/// Leaves out those that are not seen: of no area, turned away, covering no centre (as far as
/// searched_px goes), outside of the picture or of one plane.
///
/// first  A multiple of Selection::size.
using SelectTriangles = void (*)(const ScreenSlab& slab, const RegionGrid& grid, std::size_t first,
                                 Selection& selection);

/// The same bits on every target.
SelectTriangles select_triangles(isa::VectorTarget target = isa::process_target());

}  // namespace pxpl5::gp
