#include "host/inspect/tools/exec_fields.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>

#include "host/base/error.hpp"
#include "host/base/text_table.hpp"
#include "host/inspect/listing/instruction_values.hpp"

namespace pxpl5::host::inspect {

namespace {

using Bits = isa::StateColumn::Kind;

constexpr int last_px = region_px - 1;
constexpr std::uint32_t max_field_bits = 64;

[[noreturn]] void refuse_field(const std::string& text) {
    throw RequestError(
        ExitCode::usage,
        fmt::format("field '{}'; it must be surface, z, normal_x, normal_y, normal_z, rgb, m8:24 "
                    "(bits 8 to 31; {} bits, at most {} at a time), enable, carry, bs3 or readout",
                    text, isa::memory_bits, max_field_bits));
}

std::optional<std::uint32_t> number(std::string_view text) {
    std::uint32_t value = 0;
    const auto [at, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    const bool whole = error == std::errc{} && at == text.data() + text.size();
    return whole ? std::optional(value) : std::nullopt;
}

/// The field of that name, without a width; nothing if none exists.
std::optional<isa::StateColumn> named(std::string_view name) {
    constexpr std::uint32_t word = isa::backing_block_bits;
    if (name == "enable" || name == "carry") {
        return isa::StateColumn{name == "enable" ? Bits::enable : Bits::carry, 0, 1};
    }
    if (name == "readout") {
        return isa::StateColumn{Bits::readout, 0, word};
    }
    const auto block = name.starts_with("bs") ? number(name.substr(2)) : std::nullopt;
    if (block && *block < isa::backing_blocks) {
        return isa::StateColumn{Bits::block, *block, word};
    }
    const auto address = name.starts_with("m") ? number(name.substr(1)) : std::nullopt;
    if (address && *address < isa::memory_bits) {
        return isa::StateColumn{Bits::field, *address, 1};
    }
    if (const std::optional<isa::region::Field> field = field_named(name)) {
        return isa::StateColumn{Bits::field, field->address, field->width};
    }
    return std::nullopt;
}

/// "3", "0..7", "*".
std::optional<std::pair<int, int>> parse_span(std::string_view text) {
    if (text == "*") {
        return std::pair(0, last_px);
    }
    const std::size_t dots = text.find("..");
    const auto first = number(text.substr(0, dots));
    const auto last = dots == std::string_view::npos ? first : number(text.substr(dots + 2));
    if (!first || !last || *first > *last || *last > static_cast<std::uint32_t>(last_px)) {
        return std::nullopt;
    }
    return std::pair(static_cast<int>(*first), static_cast<int>(*last));
}

}  // namespace

ShownField parse_field(const std::string& text) {
    const std::size_t colon = text.find(':');
    std::optional<isa::StateColumn> column = named(std::string_view(text).substr(0, colon));
    if (column && colon != std::string::npos) {
        column->n = number(std::string_view(text).substr(colon + 1)).value_or(0);
    }
    const bool fits = column && column->n >= 1 && column->n <= max_field_bits &&
                      (column->kind != Bits::field || column->a + column->n <= isa::memory_bits);
    if (!fits) {
        refuse_field(text);
    }
    return {text, *column};
}

isa::PixelRectangle parse_window(const std::string& text) {
    const std::size_t comma = text.find(',');
    const auto x = parse_span(std::string_view(text).substr(0, comma));
    const auto y = comma == std::string::npos
                       ? std::nullopt
                       : parse_span(std::string_view(text).substr(comma + 1));
    if (!x || !y) {
        throw RequestError(ExitCode::usage,
                           fmt::format("pixels '{}'; they must be x,y, e.g. 3,5 or 0..7,9 or *,0, "
                                       "each 0 to {}",
                                       text, last_px));
    }
    return {x->first, y->first, x->second, y->second};
}

std::uint64_t value_of(const PixelsBehind& pixels, const isa::StateColumn& column, int x, int y) {
    std::uint64_t value = 0;
    switch (column.kind) {
        case Bits::field:
            return pixels.executor.field(x, y, column.a, column.n);
        case Bits::enable:
            return pixels.executor.enabled(x, y) ? 1 : 0;
        case Bits::carry:
            return pixels.executor.carry(x, y) ? 1 : 0;
        case Bits::block:
            value = pixels.executor.backing_block(x, y, column.a);
            break;
        case Bits::readout:
            if (pixels.readout.empty()) {
                throw RequestError(ExitCode::usage,
                                   "readout: the program read no pixels out (PIXELSTOFB)");
            }
            value = pixels.readout[static_cast<std::size_t>(y * region_px + x)];
            break;
    }
    return column.n >= isa::backing_block_bits ? value
                                               : value & ((std::uint64_t{1} << column.n) - 1);
}

std::string number_text(std::uint64_t value, const isa::StateColumn& column, NumberStyle style) {
    if (style.hex) {
        return fmt::format("{:x}", value);
    }
    if (style.is_signed && column.n > 1) {
        const unsigned spare = max_field_bits - column.n;
        return fmt::format("{}", static_cast<std::int64_t>(value << spare) >> spare);
    }
    return fmt::format("{}", value);
}

std::string field_table(const PixelsBehind& pixels, const ShownField& field,
                        const isa::PixelRectangle& window, NumberStyle style) {
    TableRow heading{"y\\x"};
    for (int x = window.x0; x <= window.x1; ++x) {
        heading.push_back(std::to_string(x));
    }
    std::vector<TableRow> rows;
    for (int y = window.y0; y <= window.y1; ++y) {
        TableRow& row = rows.emplace_back(TableRow{std::to_string(y)});
        for (int x = window.x0; x <= window.x1; ++x) {
            row.push_back(number_text(value_of(pixels, field.column, x, y), field.column, style));
        }
    }
    return fmt::format("{}{}\n", field.name, style.hex ? ", hexadecimal" : "") +
           text_table(heading, rows, 0);
}

FieldPicture field_picture(const PixelsBehind& pixels, const ShownField& field) {
    constexpr std::uint32_t opaque = 0xFF00'0000, gray = 0x01'0101, colors = 0xFF'FFFF;
    constexpr std::uint32_t white = 255;
    std::vector<std::uint64_t> values;
    for (int y = 0; y <= last_px; ++y) {
        for (int x = 0; x <= last_px; ++x) {
            values.push_back(value_of(pixels, field.column, x, y));
        }
    }
    const auto [low, high] = std::ranges::minmax(values);
    const bool is_color = field.column.kind == Bits::readout ||
                          (field.column == isa::StateColumn{Bits::field, isa::region::rgb.address,
                                                            isa::region::rgb.width});
    FieldPicture picture;
    picture.legend =
        is_color ? "" : fmt::format("{}: black is {}, white is {}", field.name, low, high);
    if (high == low) {
        picture.warning =
            fmt::format("{} is {} at every pixel{}", field.name, low,
                        low != 0 ? ""
                        : field.column.kind != Bits::field
                            ? "; the picture is black"
                            : fmt::format("; no instruction stored a value into "
                                          "bits {} to {} of an enabled pixel",
                                          field.column.a, field.column.a + field.column.n - 1));
    }
    const double scale = high == low ? 0 : white / static_cast<double>(high - low);
    for (const std::uint64_t value : values) {
        const auto level = static_cast<std::uint32_t>(static_cast<double>(value - low) * scale);
        picture.rgba.push_back(
            opaque | (is_color ? static_cast<std::uint32_t>(value) & colors : level * gray));
    }
    return picture;
}

}  // namespace pxpl5::host::inspect
