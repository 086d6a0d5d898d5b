// A conformance case: pixels before, a program, pixels after; and its text form.
//
//   title  An 8-bit sum carries out of its top bit
//   given      m0:8   m8:8    enable
//     all      0      x+2*y   0           ; every pixel; later rows override earlier ones
//     3,5      0xff   1       1           ; one pixel
//     0..7,9   12     -       1           ; a rectangle; - says nothing
//     x-64>=0  -      -7      -           ; where this holds
//   run
//     MEMpluseqMEM m0:8 m8
//   expect     m0:8   carry
//     3,5      0      1                   ; all else is as it was given
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

#include "isa/program.hpp"
#include "isa/region.hpp"

namespace pxpl5::isa {

/// Thrown for text that is not a conformance case; `what` names line, column, what was found and
/// what was expected.
struct ConformanceError : std::runtime_error {
    ConformanceError(const std::string& what, std::size_t line_number, std::size_t column_number)
        : std::runtime_error(what), line(line_number), column(column_number) {}
    std::size_t line, column;  ///< From 1.
};

/// A quadratic in a pixel's place, k[0] x + k[1] y + k[2] + k[3] x^2 + k[4] x y + k[5] y^2, modulo
/// 2^64; the order is that of the tree's coefficients.
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

/// Pixels x0..x1, y0..y1, all included.
struct PixelRectangle {
    int x0 = 0, y0 = 0;
    int x1 = region::size_px - 1, y1 = region::size_px - 1;
    bool contains(int x, int y) const { return x >= x0 && x <= x1 && y >= y0 && y <= y1; }
    friend bool operator==(const PixelRectangle&, const PixelRectangle&) = default;
};

/// Which pixels a row speaks of: those of a rectangle where the quadratic, if any, is >= 0, signed.
struct PixelSelector {
    PixelRectangle rectangle;
    std::optional<Quadratic> at_least_zero;
    bool selects(int x, int y) const {
        return rectangle.contains(x, y) &&
               (!at_least_zero || static_cast<std::int64_t>(at_least_zero->at(x, y)) >= 0);
    }
};

/// What a column of a table speaks of.
struct StateColumn {
    enum class Kind : std::uint8_t { field, enable, carry, block, readout };
    Kind kind = Kind::field;
    std::uint32_t a = 0;  ///< First bit of a field; number of a backing-store block.
    std::uint32_t n = 1;  ///< Width in bits: 1..64 of a field, 1 of enable and carry, else 32.
    friend bool operator==(const StateColumn&, const StateColumn&) = default;
};

/// The state of some pixels: rows in order, later ones override earlier ones.
struct StateTable {
    struct Row {
        PixelSelector where;
        std::vector<std::optional<Quadratic>> values;  ///< One per column; low n bits count.
    };
    std::vector<StateColumn> columns;
    std::vector<Row> rows;
};

struct ConformanceCase {
    std::string title;
    std::vector<PixelRectangle> watch;  ///< The pixels that are compared; empty: all.
    std::vector<StateTable> given;      ///< On pixels that are cleared and disabled.
    Program program;                    ///< Passed check(); without open parameters.
    std::vector<StateTable> expect;     ///< Changes of what was given.

    std::vector<std::uint32_t> signals;                 ///< Numbers of all SIGNALs, in order.
    bool flag = true;                                   ///< The controller's, at the end.
    std::optional<std::uint64_t> instructions, cycles;  ///< Of the run, if stated.
    std::string stops;  ///< Part of the RunError's text; empty if the program runs to its end.
};

/// Reads a case. Throws ConformanceError.
ConformanceCase parse_conformance(std::string_view text);

}  // namespace pxpl5::isa
