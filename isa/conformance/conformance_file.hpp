// A conformance case and its text form: pixels before a run, a program, pixels after the run.
//
//   title  An 8-bit sum carries out of its top bit
//   given      m0:8   m8:8    enable
//     all      0      x+2*y   0           ; every pixel; later rows override earlier ones
//     3,5      0xff   1       1           ; one pixel
//     0..7,9   12     -       1           ; a rectangle; - sets nothing
//     x-64>=0  -      -7      -           ; where this is true
//   run
//     MEMpluseqMEM m0:8 m8
//   expect     m0:8   carry
//     3,5      0      1                   ; everything else is unchanged
//
// tests/isa/conformance/README.md describes the whole format.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "generated/vocabulary.hpp"
#include "isa/program.hpp"

namespace pxpl5::isa {

/// Thrown for text that is not a conformance case. The text names the line, the column, the part
/// that was found and the part that was expected.
struct ConformanceError : std::runtime_error {
    ConformanceError(const std::string& what, std::size_t line_number, std::size_t column_number)
        : std::runtime_error(what), line(line_number), column(column_number) {}
    std::size_t line, column;  ///< Both from 1.
};

/// k[0] x + k[1] y + k[2] + k[3] x^2 + k[4] x y + k[5] y^2 of a pixel's x and y, modulo 2^64. The
/// tree's coefficients have the same order.
struct Quadratic {
    std::array<std::uint64_t, 6> k{};

    constexpr std::uint64_t at(int x_px, int y_px) const {
        const auto x = static_cast<std::uint64_t>(x_px), y = static_cast<std::uint64_t>(y_px);
        return k[0] * x + k[1] * y + k[2] + k[3] * x * x + k[4] * x * y + k[5] * y * y;
    }
    bool is_constant() const { return k[0] == 0 && k[1] == 0 && (k[3] | k[4] | k[5]) == 0; }
    /// True if each coefficient is a signed 32-bit number, as coefficient words are.
    bool fits_coefficient_words() const;
};

/// Pixels x0..x1, y0..y1, ends included.
struct PixelRectangle {
    int x0 = 0, y0 = 0;
    int x1 = region_px - 1, y1 = region_px - 1;
    bool contains(int x, int y) const { return x >= x0 && x <= x1 && y >= y0 && y <= y1; }
    friend bool operator==(const PixelRectangle&, const PixelRectangle&) = default;
};

/// The pixels of a row: those of a rectangle where the quadratic, if any, is >= 0, signed.
struct PixelSelector {
    PixelRectangle rectangle;
    std::optional<Quadratic> at_least_zero;
    bool selects(int x, int y) const {
        return rectangle.contains(x, y) &&
               (!at_least_zero || static_cast<std::int64_t>(at_least_zero->at(x, y)) >= 0);
    }
};

/// The part of a pixel's state that a column lists.
struct StateColumn {
    enum class Kind : std::uint8_t { field, enable, carry, block, readout };
    Kind kind = Kind::field;
    std::uint32_t a = 0;  ///< First bit of a field; number of a backing-store block.
    std::uint32_t n = 1;  ///< Width in bits: field 1..64, enable and carry 1, else 32.
    friend bool operator==(const StateColumn&, const StateColumn&) = default;
};

/// The state of some pixels. Later rows override earlier rows.
struct StateTable {
    struct Row {
        PixelSelector where;
        std::vector<std::optional<Quadratic>> values;  ///< One per column; the low n bits are used.
    };
    std::vector<StateColumn> columns;
    std::vector<Row> rows;
};

struct ConformanceCase {
    std::string title;
    std::vector<PixelRectangle> watch;  ///< The pixels to compare; empty: all.
    std::vector<StateTable> given;      ///< The state before; other pixels are clear and disabled.
    Program program;                    ///< Passed check(); has no parameters.
    std::vector<StateTable> expect;     ///< The changes to the given state.

    std::vector<std::uint32_t> signals;                 ///< The numbers of all SIGNALs, in order.
    bool flag = true;                                   ///< The controller's flag at the end.
    std::optional<std::uint64_t> instructions, cycles;  ///< Counts of the run, if given.
    std::string stops;  ///< Part of the RunError's text; empty if the run reaches its end.
};

/// Reads a case. Throws ConformanceError.
ConformanceCase parse_conformance(std::string_view text);

}  // namespace pxpl5::isa
