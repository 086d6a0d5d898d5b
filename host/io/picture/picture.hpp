// Pictures out: writes frames to an image file. All of OpenImageIO is behind this.
#pragma once

#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "generated/vocabulary.hpp"
#include "host/scene/marks.hpp"

namespace pxpl5::host::io {

inline constexpr int min_delay_ms = 20;  ///< Browsers show what is shorter at 100 ms.
inline constexpr std::size_t max_attributes = 1'000;
inline constexpr std::size_t max_attribute_name = 73;  ///< Bytes; PNG has 79, of which we use 6.
inline constexpr std::size_t max_jpeg_text = 30'000;   ///< A segment of JPEG has 65,533 bytes.

/// Thrown for a picture that cannot be written. `what` names the file and the reason.
struct PictureError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// A word and its value in the file's metadata.
struct PictureAttribute {
    std::string name;   ///< Printable ASCII, 1..max_attribute_name, each once.
    std::string value;  ///< UTF-8.
};

/// A picture to write, or several of one size: display-coded (sRGB) values, alpha not multiplied
/// in.
struct Picture {
    int width = 0, height = 0;                      ///< Pixels; 1..max_export_px.
    std::span<const std::uint8_t> rgba;             ///< count * width * height * 4, top row first.
    std::string description;                        ///< Goes into the file's metadata.
    std::vector<PictureAttribute> attributes = {};  ///< Likewise, as "pxpl5:NAME".
    std::vector<PictureMark> marks = {};            ///< Drawn over each picture, in order.
    /// 1..max_animation_pictures; more than one: an animation, which only GIF holds, or the left
    /// and the right eye of an .mpo file.
    int count = 1;
    int delay_ms = 40;  ///< Between an animation's pictures; GIF has steps of 10 ms.
};

/// The attribute that states the distance between the eyes of an .mpo file.
inline constexpr std::string_view separation_attribute = "separation_mm";

/// Writes `picture` to `path`. The suffix selects PNG, TIFF, OpenEXR, GIF, SVG, PDF, or JPEG for a
/// stereo pair: .jps for one picture of both eyes, .mpo for two pictures in one file. The file
/// appears whole or not at all: it is written beside its place and renamed. The file has alpha only
/// if a pixel is not opaque. GIF has no alpha and 256 dithered colors per picture, JPEG no alpha,
/// 95 % quality and a color for each pixel. Marks stay lines and letters in SVG and PDF.
///
/// Attributes are texts of their own in PNG and OpenEXR. TIFF has no room for names that it does
/// not know, nor has JPEG: there they are lines of the description. GIF, SVG and PDF hold none.
/// Throws   PictureError.
void write_picture(const std::string& path, const Picture& picture);

}  // namespace pxpl5::host::io
