// Pictures out: writes a frame to an image file. All of OpenImageIO is behind this.
#pragma once

#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>

namespace pxpl5::host::io {

inline constexpr int max_picture_side_px = 16384;

/// Thrown for a picture that cannot be written. `what` names the file and the reason.
struct PictureError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// A picture to write: display-coded (sRGB) values, alpha not multiplied in.
struct Picture {
    int width = 0, height = 0;           ///< Pixels; 1..max_picture_side_px.
    std::span<const std::uint8_t> rgba;  ///< width * height * 4, top row first.
    std::string description;             ///< Goes into the file's metadata.
};

/// Writes `picture` to `path` as PNG, TIFF or OpenEXR, by its suffix. The file appears whole or
/// not at all: it is written beside its place and renamed. Alpha is kept only if some pixel is
/// not opaque.
/// Throws   PictureError.
void write_picture(const std::string& path, const Picture& picture);

}  // namespace pxpl5::host::io
