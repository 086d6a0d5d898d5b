// Writes a picture with an io process of its own, for tools that have no machine.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "host/base/command_line.hpp"
#include "host/chart/chart.hpp"

namespace pxpl5::host {

/// A picture, and the marks over it.
struct WrittenPicture {
    Size size;
    std::span<const std::uint32_t> rgba;  ///< Red in the low byte, top row first.
    std::span<const PictureMark> marks;
    std::string description;  ///< UTF-8; goes into the file.
};

/// Throws RequestError (usage) if the suffix is not .png, .svg or .pdf. `option` names the option
/// in the text.
void check_picture_suffix(const std::string& option, const std::string& path);

/// Writes the file; the suffix selects the format. The file appears whole or not at all.
/// Throws RequestError: failed, with the file and the reason; unavailable if pxpl5-io cannot start.
void write_picture(const std::string& path, const WrittenPicture& picture);

/// Writes a chart. A PNG has twice the chart's size in pixels.
void write_chart(const std::string& path, const Chart& chart, const std::string& description);

}  // namespace pxpl5::host
