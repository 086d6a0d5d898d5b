// Writes pictures without a machine: no io process is needed to look at what was recorded.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

namespace pxpl5::host::inspect {

/// Writes a PNG file.
///
/// width, height  Pixels, 1 or more each.
/// rgba           width * height pixels, top row first, red in the low byte, alpha in the high one.
///
/// Throws RequestError (failed) naming file and reason.
void write_png(const std::filesystem::path& path, int width, int height,
               std::span<const std::uint32_t> rgba);

}  // namespace pxpl5::host::inspect
