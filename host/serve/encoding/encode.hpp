// A frame as the bytes that go to a viewer.
#pragma once

#include <compare>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "generated/page_schema.hpp"

namespace pxpl5::host::serve {

/// The header as it precedes the picture in a message.
std::string frame_header(const FrameHeader& header);

/// The pixels without loss, as a PNG file. Alpha is left out: a frame is opaque.
///
/// rgba  width * height pixels, top row first, red in the low byte.
///
/// Throws std::runtime_error with the encoder's reason.
std::string png_of(int width, int height, std::span<const std::uint32_t> rgba);

/// How much a JPEG keeps. Better choices compare greater.
struct JpegQuality {
    int quality = 80;  ///< 1 to 100.
    /// The color of each pixel (4:4:4), not of 2 x 2 pixels (4:2:0).
    bool full_color = false;

    auto operator<=>(const JpegQuality&) const = default;
};

/// Likewise as a JPEG file.
std::string jpeg_of(int width, int height, std::span<const std::uint32_t> rgba,
                    JpegQuality quality);

/// The layers of each view as one picture, for viewers who show no layers. Per channel: (front *
/// opacity + behind * (16 - opacity)) / 16, halves rounded up. This is the mean of the pixels of a
/// screen door, each of which shows one of the layers.
///
/// rgba     For each view: the layer behind, then the layer in front.
/// opacity  Opacity of the layer in front, sixteenths.
std::vector<std::uint32_t> blended(std::span<const std::uint32_t> rgba, int views, int opacity);

}  // namespace pxpl5::host::serve
