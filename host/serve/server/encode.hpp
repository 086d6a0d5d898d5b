// A frame as the bytes that go to a viewer.
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace pxpl5::host::serve {

enum class PictureKind : std::uint8_t { jpeg = 1, png = 2 };

/// The header's fields, as host/serve/README.md lays them out.
struct FrameHeader {
    std::uint32_t number = 0;  ///< Counted from 1 for each viewer.
    std::uint32_t revision = 0;
    int width = 0, height = 0;
    PictureKind kind = PictureKind::png;
    int quality = 0;  ///< Of the JPEG, 1 to 100.
    int samples = 1;
    bool rests = false, last = false;
    float machine_ms = 0;
    std::uint64_t digest = 0;
};

inline constexpr std::size_t frame_header_bytes = 32;

/// frame_header_bytes bytes, little-endian.
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
