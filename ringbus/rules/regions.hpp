// Regions of a picture: all nodes count them alike. Plain, for every stage.
#pragma once

#include <cstddef>
#include <cstdint>

#include "generated/vocabulary.hpp"

namespace pxpl5 {

/// Regions that cover `px` pixels of a row or a column.
constexpr std::uint32_t regions_across(std::uint32_t px) {
    return (px + region_px - 1) / region_px;
}

/// Regions of a picture over all views: row by row from the top left, then view by view.
constexpr std::size_t region_count(std::uint32_t width, std::uint32_t height, std::size_t views) {
    return std::size_t{regions_across(width)} * regions_across(height) * views;
}

inline constexpr std::size_t max_regions = region_count(max_picture_px, max_picture_px, max_views);

}  // namespace pxpl5
