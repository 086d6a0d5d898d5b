#include "host/frame_buffer/frame.hpp"

#include <algorithm>
#include <cassert>
#include <cstddef>

#include "ringbus/rules/regions.hpp"
#include "ringbus/rules/views.hpp"

namespace pxpl5::host {

namespace {

constexpr std::uint32_t full_alpha = 0xff000000;

/// Copies one region into its place, cropped to the view, and calls `finish` with each row there.
template <typename Finish>
void copy_region(const FrameShape& shape, int region, std::span<const std::uint32_t> tile,
                 std::span<std::uint32_t> picture, const Finish& finish) {
    assert(region >= 0 && region < shape.regions());
    assert(tile.size() == region_pixels);
    assert(picture.size() == shape.pixels());
    const int per_view = shape.columns() * shape.rows();
    const int view = region / per_view, in_view = region % per_view;
    const int left = in_view % shape.columns() * region_px,
              top = in_view / shape.columns() * region_px;
    const int width = std::min(region_px, shape.width - left);
    const int height = std::min(region_px, shape.height - top);
    for (int y = 0; y < height; ++y) {
        const std::uint32_t* from = tile.data() + std::ptrdiff_t{y} * region_px;
        std::uint32_t* to =
            picture.data() +
            static_cast<std::ptrdiff_t>(view * shape.height + top + y) * shape.width + left;
        std::copy_n(from, width, to);  // Quicker than a copy that changes the words.
        finish(std::span(to, static_cast<std::size_t>(width)));
    }
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
    copy_region(shape, region, tile, picture, [](std::span<std::uint32_t> row) {
        for (std::uint32_t& pixel : row) {
            pixel |= full_alpha;
        }
    });
}

void place_depths(const FrameShape& shape, int region, std::span<const std::uint32_t> tile,
                  std::span<std::uint32_t> depths) {
    copy_region(shape, region, tile, depths, [](std::span<std::uint32_t>) {});
}

}  // namespace pxpl5::host
