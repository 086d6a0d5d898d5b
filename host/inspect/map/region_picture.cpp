#include "host/inspect/map/region_picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <iterator>

#include "host/base/error.hpp"
#include "host/inspect/map/map_colors.hpp"
#include "isa/contract/region_layout.hpp"

namespace pxpl5::host::inspect {

namespace {

namespace layout = isa::region;
constexpr Rgb8 black{}, white{255, 255, 255};

const std::vector<NamedField>& names() {
    using Place = NamedField::Kind;
    const auto memory = [](const char* name, layout::Field f) {
        return NamedField{Place::memory, name, f.address, f.width};
    };
    static const std::vector<NamedField> fields = {
        {Place::enable, "enable", 0, 1},
        {Place::carry, "carry", 0, 1},
        memory("surface", layout::surface),
        memory("z", layout::z),
        memory("normal", {layout::normal_x.address, 3 * layout::normal_x.width}),
        memory("nx", layout::normal_x),
        memory("ny", layout::normal_y),
        memory("nz", layout::normal_z),
        memory("rgb", layout::rgb),
    };
    return fields;
}

/// "64:24"; nothing if it is no such text or leaves the memory.
std::optional<NamedField> bits_of(std::string_view text) {
    NamedField field;
    const char* end = text.data() + text.size();
    const auto first = std::from_chars(text.data(), end, field.address);
    if (first.ec != std::errc{} || first.ptr == end || *first.ptr != ':') {
        return std::nullopt;
    }
    const auto second = std::from_chars(first.ptr + 1, end, field.width);
    const bool fits = field.width >= 1 && field.width <= 64 && field.address < isa::memory_bits &&
                      field.address + field.width <= isa::memory_bits;
    if (second.ec != std::errc{} || second.ptr != end || !fits) {
        return std::nullopt;
    }
    field.name = text;
    return field;
}

double component(std::uint64_t normal, unsigned k) {
    const int field = static_cast<int>(normal >> (10 * k) & 0x3FF);
    return (field < 512 ? field : field - 1024) / double{layout::normal_unit};
}

/// The range of a field's values, `without` left out.
struct ValueRange {
    std::uint64_t least = ~std::uint64_t{0}, most = 0;
    void take(std::uint64_t value) {
        least = std::min(least, value);
        most = std::max(most, value);
    }
    double part(std::uint64_t value) const {
        return most <= least
                   ? 1.0
                   : static_cast<double>(value - least) / static_cast<double>(most - least);
    }
};

Rgb8 color_of(const NamedField& field, std::uint64_t value, const ValueRange& range) {
    if (field.kind != NamedField::Kind::memory) {
        return value != 0 ? white : black;
    }
    if (field.name == "rgb") {
        return {static_cast<std::uint8_t>(value), static_cast<std::uint8_t>(value >> 8),
                static_cast<std::uint8_t>(value >> 16)};
    }
    if (field.name == "normal") {
        return value == 0
                   ? black
                   : directional(component(value, 0), component(value, 1), component(value, 2));
    }
    if (field.name == "surface") {
        return value == 0 ? black : categorical(static_cast<std::uint32_t>(value - 1));
    }
    if (field.name == "z") {
        return value == layout::z_far ? black : mix(white, {40, 40, 40}, range.part(value));
    }
    return sequential(range.part(value));
}

/// Mean color of a box of pixels.
Rgb8 mean(const std::vector<std::uint32_t>& picture, int side, int x0, int y0, int width,
          int height) {
    std::uint32_t sum[3] = {}, count = 0;
    for (int y = y0; y < std::min(y0 + height, side); ++y) {
        for (int x = x0; x < std::min(x0 + width, side); ++x, ++count) {
            const std::uint32_t pixel = picture[static_cast<std::size_t>(y * side + x)];
            for (unsigned k = 0; k < 3; ++k) {
                sum[k] += pixel >> (8 * k) & 0xFF;
            }
        }
    }
    const auto channel = [&](unsigned k) {
        return static_cast<std::uint8_t>(count == 0 ? 0 : sum[k] / count);
    };
    return {channel(0), channel(1), channel(2)};
}

double light_of(Rgb8 color) {
    return (0.2126 * color.r + 0.7152 * color.g + 0.0722 * color.b) / 255;
}

/// The brightest pixel's; letters are so few that none should be given away.
double brightest(const std::vector<std::uint32_t>& picture) {
    double most = 1.0 / 255;
    for (const std::uint32_t pixel : picture) {
        most = std::max(
            most, light_of({static_cast<std::uint8_t>(pixel), static_cast<std::uint8_t>(pixel >> 8),
                            static_cast<std::uint8_t>(pixel >> 16)}));
    }
    return most;
}

/// light  0..1
char letter_of(double light) {
    constexpr std::string_view ramp = " .:-=+*#%@";
    return ramp[std::min(static_cast<std::size_t>(light * ramp.size()), ramp.size() - 1)];
}

}  // namespace

std::uint64_t NamedField::value(const isa::Executor& executor, int x, int y) const {
    switch (kind) {
        case Kind::enable:
            return executor.enabled(x, y) ? 1 : 0;
        case Kind::carry:
            return executor.carry(x, y) ? 1 : 0;
        case Kind::memory:
            break;
    }
    return executor.field(x, y, address, width);
}

NamedField field_of(std::string_view text) {
    const auto found = std::ranges::find(names(), text, &NamedField::name);
    if (found != names().end()) {
        return *found;
    }
    if (const auto field = bits_of(text)) {
        return *field;
    }
    std::string all;
    for (const NamedField& field : names()) {
        all += field.name + ", ";
    }
    throw RequestError(ExitCode::usage,
                       fmt::format("there is no field '{}'; there are {}or bits as 64:24, of the "
                                   "{} of a pixel, 64 at most",
                                   text, all, isa::memory_bits));
}

std::vector<std::uint32_t> picture_of(const isa::Executor& executor, const NamedField& field) {
    std::vector<std::uint64_t> values(region_pixels);
    ValueRange range;
    for (std::size_t i = 0; i < values.size(); ++i) {
        values[i] =
            field.value(executor, static_cast<int>(i) % region_px, static_cast<int>(i) / region_px);
        if (field.name != "z" || values[i] != layout::z_far) {
            range.take(values[i]);
        }
    }
    std::vector<std::uint32_t> picture(values.size());
    std::ranges::transform(values, picture.begin(), [&](std::uint64_t value) {
        return color_of(field, value, range).opaque();
    });
    return picture;
}

std::string terminal_text(const std::vector<std::uint32_t>& picture, int side,
                          TerminalStyle style) {
    // A letter is about twice as high as wide: a half block is square, a letter takes two rows.
    const int box = std::max(1, (side + style.columns - 1) / std::max(style.columns, 1));
    const double full = brightest(picture);
    std::string text;
    for (int y = 0; y < side; y += 2 * box) {
        for (int x = 0; x < side; x += box) {
            if (style.color) {
                const Rgb8 up = mean(picture, side, x, y, box, box);
                const Rgb8 down = mean(picture, side, x, y + box, box, box);
                fmt::format_to(std::back_inserter(text),
                               "\x1b[38;2;{};{};{}m\x1b[48;2;{};{};{}m\u2580", up.r, up.g, up.b,
                               down.r, down.g, down.b);
            } else {
                text += letter_of(light_of(mean(picture, side, x, y, box, 2 * box)) / full);
            }
        }
        text += style.color ? "\x1b[0m\n" : "\n";
    }
    return text;
}

}  // namespace pxpl5::host::inspect
