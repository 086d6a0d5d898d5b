// The results of a recorded frame: the pixels that Renderers sent and that the host received.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host/frame_buffer/frame.hpp"
#include "host/inspect/record/recorded_run.hpp"
#include "isa/sequencer.hpp"

namespace pxpl5::host::inspect {

/// A region as its Renderer sent it.
struct RecordedTile {
    std::span<const std::uint32_t> pixels;  ///< 128 * 128, row by row. Points into the frame.
    std::span<const std::uint32_t> depths;  ///< Likewise; empty if the frame wanted none, or
                                            ///< if nothing is drawn in the region.
    isa::RunCounts counts;
};

/// Empty if the frame buffer's trace does not have the region.
std::optional<RecordedTile> tile_of(const RecordedFrame& frame, std::uint32_t region);

FrameShape shape_of(const RecordedFrame& frame);

/// The picture that several frame buffers have sent, views stacked. Empty if one frame buffer has
/// sent all views, or if a part is missing.
std::vector<std::uint32_t> joined_picture(const RecordedFrame& frame);

/// The frame that the host received, shape_of() pixels; empty if not recorded or not read back.
std::span<const std::uint32_t> picture_of(const RecordedFrame& frame);

/// A region of a picture, 128 * 128 pixels; 0 where it reaches beyond.
std::vector<std::uint32_t> cut_out(const RecordedFrame& frame, std::uint32_t region,
                                   std::span<const std::uint32_t> picture);

/// The digest that the `digest` command of a session prints.
std::uint64_t digest_of(std::span<const std::uint32_t> picture);

/// A pixel of the whole picture that differs.
struct PixelDifference {
    int x = 0, y = 0;                       ///< In the picture, views stacked.
    std::uint32_t found = 0, expected = 0;  ///< Red in the low byte.
};

/// The first pixel, row by row, of a region that lies in the picture and differs in color.
///
/// tile      128 * 128 pixels.
/// expected  128 * 128 pixels, too.
std::optional<PixelDifference> compare_tiles(const RecordedFrame& frame, std::uint32_t region,
                                             std::span<const std::uint32_t> tile,
                                             std::span<const std::uint32_t> expected);

/// "#8a372f": red, green, blue. A pixel's word has red in the low byte.
std::string color_text(std::uint32_t pixel);

/// "red is 12 in A and 14 in B (bit 1), blue is 3 in A and 0 in B (bits 0, 1)"
std::string color_difference(const PixelDifference& pixel, std::string_view found_in,
                             std::string_view expected_in);

/// "region 5 (column 1, row 1)", with the view if there are several.
std::string region_name(const RecordedFrame& frame, std::uint32_t region);

}  // namespace pxpl5::host::inspect
