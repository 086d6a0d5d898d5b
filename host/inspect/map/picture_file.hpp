// Writes pictures without a machine and without an io process.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

namespace pxpl5::host::inspect {

/// Throws RequestError (usage) if the name of a picture does not end in .png.
void check_png_name(const std::filesystem::path& path);

/// Writes a PNG file. Throws as check_png_name().
///
/// width, height  Pixels, 1 or more each.
/// rgba           width * height pixels, top row first, red in the low byte, alpha in the high one.
///
/// Throws RequestError (failed) naming file and reason.
void write_png(const std::filesystem::path& path, int width, int height,
               std::span<const std::uint32_t> rgba);

}  // namespace pxpl5::host::inspect
