// A frame as the bytes that go to a viewer.
#pragma once

#include <cstdint>
#include <span>
#include <string>

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

/// Likewise as a JPEG file.
///
/// quality  1 to 100.
std::string jpeg_of(int width, int height, std::span<const std::uint32_t> rgba, int quality);

}  // namespace pxpl5::host::serve
