#include "host/frame_buffer/frame.hpp"

#include <algorithm>
#include <cassert>
#include <cstddef>

#include "ringbus/rules/regions.hpp"
#include "ringbus/rules/views.hpp"

namespace pxpl5::host {

namespace {

constexpr std::uint32_t full_alpha = 0xff000000;

/// Calls `put` with the number and the place of each row of a region, cropped to the view.
template <typename Put>
void each_row(const FrameShape& shape, int region, std::span<std::uint32_t> picture,
              const Put& put) {
    assert(region >= 0 && region < shape.regions());
    assert(picture.size() == shape.pixels());
    const int per_view = shape.columns() * shape.rows();
    const int view = region / per_view, in_view = region % per_view;
    const int left = in_view % shape.columns() * region_px,
              top = in_view / shape.columns() * region_px;
    const int width = std::min(region_px, shape.width - left);
    const int height = std::min(region_px, shape.height - top);
    for (int y = 0; y < height; ++y) {
        const std::size_t first = static_cast<std::size_t>(view * shape.height + top + y) *
                                      static_cast<std::size_t>(shape.width) +
                                  static_cast<std::size_t>(left);
        put(static_cast<std::size_t>(y), picture.subspan(first, static_cast<std::size_t>(width)));
    }
}

/// The words of a row of a region.
std::span<const std::uint32_t> row_of(std::span<const std::uint32_t> tile, std::size_t y,
                                      std::size_t width) {
    assert(tile.size() == region_pixels);
    return tile.subspan(y * static_cast<std::size_t>(region_px), width);
}

}  // namespace

int FrameShape::columns() const {
    return static_cast<int>(regions_across(static_cast<std::uint32_t>(width)));
}
int FrameShape::rows() const {
    return static_cast<int>(regions_across(static_cast<std::uint32_t>(height)));
}

std::size_t FrameShape::pixels() const {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
           static_cast<std::size_t>(views);
}

bool Frame::complete() const {
    return std::find(renderer_is_in.begin(), renderer_is_in.end(), false) == renderer_is_in.end();
}

std::optional<std::size_t> Frame::own_region(std::size_t region) const {
    const auto per_view = static_cast<std::size_t>(whole.columns() * whole.rows());
    const std::size_t view = region / per_view;
    if (frame_buffer_of(view, share.frame_buffers) != share.index) {
        return std::nullopt;
    }
    return view_place(view, share.frame_buffers) * per_view + region % per_view;
}

void place_region(const FrameShape& shape, int region, std::span<const std::uint32_t> tile,
                  std::span<std::uint32_t> picture) {
    each_row(shape, region, picture, [&](std::size_t y, std::span<std::uint32_t> row) {
        std::ranges::copy(row_of(tile, y, row.size()), row.begin());
        for (std::uint32_t& pixel : row) {  // Quicker than a copy that changes the words.
            pixel |= full_alpha;
        }
    });
}

void place_depths(const FrameShape& shape, int region, std::span<const std::uint32_t> tile,
                  std::span<std::uint32_t> depths) {
    each_row(shape, region, depths, [&](std::size_t y, std::span<std::uint32_t> row) {
        std::ranges::copy(row_of(tile, y, row.size()), row.begin());
    });
}

void fill_region(const FrameShape& shape, int region, std::uint32_t word,
                 std::span<std::uint32_t> picture) {
    each_row(shape, region, picture,
             [word](std::size_t, std::span<std::uint32_t> row) { std::ranges::fill(row, word); });
}

}  // namespace pxpl5::host
