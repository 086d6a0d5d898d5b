// One frame on its way to being complete.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace pxpl5::host {

/// Regions of 128 x 128 pixels count row by row from the top left, then over the views.
struct FrameShape {
    int width = 0, height = 0;  ///< Pixels of one view.
    int views = 1;              ///< Stacked top to bottom in the picture.

    int columns() const;
    int rows() const;  ///< Rows of one view.
    int regions() const { return columns() * rows() * views; }
    std::size_t pixels() const;
};

/// Which views of a frame one frame buffer assembles: see frame_buffer_of().
struct ViewShare {
    std::size_t index = 0;          ///< This frame buffer.
    std::size_t frame_buffers = 1;  ///< Count in the machine.
};

/// A frame that has begun, as far as its views belong to this frame buffer. Regions count over
/// these views, except in messages of Renderers.
struct Frame {
    std::uint32_t number = 0;
    FrameShape shape;
    FrameShape whole;  ///< With the views of all frame buffers.
    ViewShare share;
    bool read_back = false;
    bool read_depths = false;
    bool has_pixels = true;                    ///< False of a pass that is not its picture's last.
    std::vector<std::uint16_t> assignment;     ///< Index of the Renderer, by region.
    std::vector<bool> renderer_is_in;          ///< By index.
    std::vector<bool> region_is_in;            ///< By region.
    std::vector<std::uint64_t> region_cycles;  ///< By region.
    std::uint64_t instructions = 0;            ///< Over all regions.
    double moved_mm = 0;                       ///< The largest of the Renderers' messages.
    std::span<std::uint32_t> picture;  ///< shape.pixels(), top row first; empty unless read_back.
    std::span<std::uint32_t> depths;   ///< Likewise; empty unless read_depths.

    bool complete() const;
    /// The region that has this number in the whole frame. Nothing if another frame buffer
    /// assembles its view.
    std::optional<std::size_t> own_region(std::size_t region) const;
};

/// Copies one region into its place, cropped to the view, with every alpha at 255.
///
/// tile     128 * 128 pixels, top row first, red in the low byte.
/// picture  shape.pixels() pixels.
void place_region(const FrameShape& shape, int region, std::span<const std::uint32_t> tile,
                  std::span<std::uint32_t> picture);

/// The same for what the pixels show and how far away it is: words stay as they are.
void place_depths(const FrameShape& shape, int region, std::span<const std::uint32_t> tile,
                  std::span<std::uint32_t> depths);

/// Gives all pixels of a region the same word.
void fill_region(const FrameShape& shape, int region, std::uint32_t word,
                 std::span<std::uint32_t> picture);

}  // namespace pxpl5::host
