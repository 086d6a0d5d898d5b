// A region's pixels as a picture: any field, in colors; and a picture as text for a terminal.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "renderer_firmware/fast/fast.hpp"

namespace pxpl5::host::inspect {

/// A field of pixel memory, or a bit beside it.
struct NamedField {
    enum class Kind : std::uint8_t { memory, enable, carry };
    Kind kind = Kind::memory;
    std::string name;
    std::uint32_t address = 0, width = 1;  ///< Bits of memory; at most 64.

    /// Returns the value of pixel (x, y) of the region.
    std::uint64_t value(const isa::Executor& executor, int x, int y) const;
};

/// enable, carry, surface, z, normal, nx, ny, nz, rgb, or bits as 64:24 (from bit 64 on, 24).
/// Throws RequestError (usage) that lists the names.
NamedField field_of(std::string_view text);

/// The whole region, 128 x 128, row by row; opaque, red in the low byte. Bits are white, rgb is as
/// it is, z is gray and near is light, surfaces have colors of their own, normals go to colors by
/// component, anything else is dark at its least value and light at its largest.
std::vector<std::uint32_t> picture_of(const isa::Executor& executor, const NamedField& field);

struct TerminalStyle {
    int columns = 80;    ///< Columns of the terminal.
    bool color = false;  ///< 24-bit escapes and half blocks; else letters by brightness.
};

/// A square picture of `side` x `side` pixels as lines of text, averaged down to the width.
std::string terminal_text(const std::vector<std::uint32_t>& picture, int side, TerminalStyle style);

}  // namespace pxpl5::host::inspect
