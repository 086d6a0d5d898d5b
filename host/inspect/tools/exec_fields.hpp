// Fields of pixels in `pxpl5 exec`: by name, as a table and as a picture.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "isa/conformance/conformance_file.hpp"
#include "isa/executor.hpp"

namespace pxpl5::host::inspect {

/// A column of the pixels' state, and its name on the command line.
struct ShownField {
    std::string name;
    isa::StateColumn column;
};

/// "z", "normal_x", "m88:16", "z:8" (its low bits), "enable", "carry", "bs3", "readout".
/// Throws RequestError (usage).
ShownField parse_field(const std::string& text);

/// Pixels of a region, ends included: "3,5", "0..7,9", "*,0". Throws RequestError (usage).
isa::PixelRectangle parse_window(const std::string& text);

/// Pixels after a program has run.
struct PixelsBehind {
    const isa::Executor& executor;
    std::span<const std::uint32_t> readout;  ///< Words of the last PIXELSTOFB; empty without one.
};

/// Throws RequestError (usage) if no pixels were read out.
std::uint64_t value_of(const PixelsBehind& pixels, const isa::StateColumn& column, int x, int y);

struct NumberStyle {
    bool hex = false, is_signed = false;
};
std::string number_text(std::uint64_t value, const isa::StateColumn& column, NumberStyle style);

/// A table: columns are x, rows are y.
std::string field_table(const PixelsBehind& pixels, const ShownField& field,
                        const isa::PixelRectangle& window, NumberStyle style);

/// The region as a picture: readout and rgb in color, any other field in gray.
struct FieldPicture {
    std::vector<std::uint32_t> rgba;  ///< 128 * 128.
    std::string legend;               ///< The values of black and white; empty for colors.
    std::string warning;              ///< Not empty if all pixels have the same value.
};
FieldPicture field_picture(const PixelsBehind& pixels, const ShownField& field);

}  // namespace pxpl5::host::inspect
