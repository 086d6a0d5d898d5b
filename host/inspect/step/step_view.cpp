#include "host/inspect/step/step_view.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <iterator>
#include <memory>

#include "host/base/error.hpp"
#include "host/inspect/listing/enabled_pixels.hpp"
#include "host/inspect/map/map_values.hpp"
#include "isa/contract/region_layout.hpp"
#include "isa/disassemble.hpp"

namespace pxpl5::host::inspect {

namespace {

namespace hal = renderer::hal;
namespace layout = isa::region;

/// A stretch of pixel memory with a name.
struct Stretch {
    const char* name;
    std::uint32_t address, width;
};
constexpr Stretch stretches[] = {
    {"surface", layout::surface.address, layout::surface.width},
    {"z", layout::z.address, layout::z.width},
    {"normal", layout::normal_x.address, 3 * layout::normal_x.width},
    {"bits 62-63", 62, 2},
    {"rgb", layout::rgb.address, layout::rgb.width},
    {"scratch 88-151", 88, 64},
    {"scratch 152-207", 152, 56},
};

/// "z of 37 pixels, surface of 37 pixels"; what differs.
std::string changes(const hal::PixelArray& before, const hal::PixelArray& after) {
    std::string text;
    const auto add = [&](const char* name, std::size_t count) {
        if (count > 0) {
            text += fmt::format("{}{} of {} pixel{}", text.empty() ? "" : ", ", name, count,
                                count == 1 ? "" : "s");
        }
    };
    for (const Stretch& s : stretches) {
        std::size_t count = 0;
        for (std::size_t i = 0; i < region_pixels; ++i) {
            count += hal::field(before, i, s.address, s.width) !=
                             hal::field(after, i, s.address, s.width)
                         ? 1
                         : 0;
        }
        add(s.name, count);
    }
    std::size_t carries = 0;
    for (std::size_t i = 0; i < before.carry.size(); ++i) {
        carries += static_cast<std::size_t>(
            std::popcount(static_cast<std::uint8_t>(before.carry[i] ^ after.carry[i])));
    }
    add("carry", carries);
    return text;
}

std::string numbered(const RegionWalk& walk) {
    return fmt::format("#{:<6} {:<28} {}", walk.counts().instructions,
                       to_text(walk.plan(), walk.at()),
                       isa::disassemble(walk.next(), walk.coefficients()));
}

std::string end_line(const Stepper& stepper) {
    const isa::RunCounts& counts = stepper.here().walk().counts();
    return fmt::format("region {} of frame {} is drawn: {} instructions, {} cycles",
                       stepper.region().place.number, stepper.frame().number, counts.instructions,
                       counts.cycles);
}

/// Effects of an instruction outside pixel memory.
std::string side_effect(const isa::OpInfo& row, const hal::PixelArray& pixels) {
    const auto has = [&row](isa::Effects effect) { return (row.effects & effect) != 0; };
    if (has(isa::flag)) {
        return pixels.any_enabled() ? "flag is 1" : "flag is 0";
    }
    if (has(isa::backing)) {
        return "backing store";
    }
    return row.name == "PIXELSTOFB" ? "pixels sent to the frame buffer" : "";
}

std::string primitive_text(const Stepper& stepper) {
    if (stepper.here().done()) {
        return "";
    }
    const Address address = stepper.here().walk().at();
    const Primitive* primitive = primitive_at(stepper.primitives(), address);
    if (primitive == nullptr) {
        return "";
    }
    std::string text = fmt::format("primitive  {} of {}, at word {} of its {}", primitive->number,
                                   stepper.primitives().size(),
                                   address.word - primitive->first_word, primitive->word_count);
    if (const auto& origin = primitive->origin) {
        const std::uint32_t slab = stepper.region().plan.parts[address.part].segment.slab;
        text += fmt::format("; voxel cell ({}, {}, {}), case 0x{:02X} (class {}), triangle {}",
                            origin->i(), origin->j(), slab, origin->inside(),
                            case_class(origin->inside()), origin->triangle());
    }
    return text + "\n";
}

/// Place of a picture's pixel in the region. Throws RequestError (usage) if it is in another one.
hal::Place in_region(const Stepper& stepper, int x, int y) {
    const RegionPlace place = stepper.frame().region_at(x, y);
    const std::uint32_t here = stepper.region().place.number;
    if (place.number != here) {
        throw RequestError(ExitCode::usage,
                           fmt::format("pixel ({}, {}) is in region {}, and this is region {}: "
                                       "'goto pixel {} {}' goes there",
                                       x, y, place.number, here, x, y));
    }
    return {static_cast<std::size_t>(x - place.x0_px), static_cast<std::size_t>(y - place.y0_px)};
}

}  // namespace

std::string next_line(const Stepper& stepper) {
    return stepper.here().done() ? end_line(stepper) : numbered(stepper.here().walk());
}

std::string done_line(Stepper& stepper) {
    if (stepper.here().executed() == 0) {
        return next_line(stepper);
    }
    stepper.back();
    const auto before = std::make_unique<hal::PixelArray>(stepper.here().executor().pixels());
    const isa::OpInfo& row = isa::info(stepper.here().walk().next().op);
    std::string text = numbered(stepper.here().walk());
    stepper.step();
    const hal::PixelArray& after = stepper.here().executor().pixels();
    std::string what = changes(*before, after);
    const std::string side = side_effect(row, after);
    what += (what.empty() || side.empty() ? "" : ", ") + side;
    text =
        fmt::format("{:<76}  enabled {} -> {}", text, enabled_count(*before), enabled_count(after));
    text += what.empty() ? "" : "  changed: " + what;
    return stepper.here().done() ? text + "\n" + end_line(stepper) : text;
}

std::string where_text(const Stepper& stepper) {
    const RegionPlace& place = stepper.region().place;
    const RegionStepper& here = stepper.here();
    std::string text = fmt::format(
        "frame      {}\nregion     {} (column {}, row {}), drawn by renderer-{}; its top left is "
        "pixel ({}, {})\n",
        stepper.frame().number, place.number, place.column, place.row, stepper.region().renderer,
        place.x0_px, place.y0_px);
    text += fmt::format("executed   {} instructions, {} cycles of this region\n", here.executed(),
                        here.walk().counts().cycles);
    text += fmt::format("enabled    {} of {} pixels\n", enabled_count(here.executor().pixels()),
                        region_pixels);
    text += primitive_text(stepper);
    text += "next       " + next_line(stepper);
    if (!here.done()) {
        const isa::OpInfo& row = isa::info(here.walk().next().op);
        text += fmt::format("\nmeaning    {}", row.doc);
    }
    return text;
}

std::string pixel_text(const Stepper& stepper, int x, int y) {
    const hal::Place place = in_region(stepper, x, y);
    const int rx = static_cast<int>(place.x), ry = static_cast<int>(place.y);
    const isa::Executor& executor = stepper.here().executor();
    const auto field = [&](layout::Field f) { return executor.field(rx, ry, f.address, f.width); };
    const auto signed_field = [&](layout::Field f) {
        const auto value = static_cast<int>(field(f));
        return value < 512 ? value : value - 1024;
    };
    const std::uint64_t rgb = field(layout::rgb), z = field(layout::z);
    std::string text = fmt::format("pixel ({}, {}), ({}, {}) in region {}\n", x, y, rx, ry,
                                   stepper.region().place.number);
    text += fmt::format("enable     {}\ncarry      {}\n", executor.enabled(rx, ry) ? 1 : 0,
                        executor.carry(rx, ry) ? 1 : 0);
    text += fmt::format("surface    {}{}\n", field(layout::surface),
                        field(layout::surface) == 0 ? " (background)" : "");
    text += fmt::format("z          {}{}\n", z, z == layout::z_far ? " (far)" : "");
    text += fmt::format("normal     {} {} {} (unit length is {})\n", signed_field(layout::normal_x),
                        signed_field(layout::normal_y), signed_field(layout::normal_z),
                        layout::normal_unit);
    text += fmt::format("rgb        {} {} {}\nbits", rgb & 0xFF, rgb >> 8 & 0xFF, rgb >> 16);
    for (std::uint32_t bit = 0; bit < isa::memory_bits; bit += 32) {
        const std::uint32_t n = std::min(32U, isa::memory_bits - bit);
        text += fmt::format("{}{}:{} 0x{:0{}x}", bit % 128 == 0 && bit != 0 ? "\n    " : "  ", bit,
                            n, executor.field(rx, ry, bit, n), n / 4);
    }
    return text;
}

std::string list_text(const Stepper& stepper, int lines) {
    if (stepper.here().done()) {
        return end_line(stepper);
    }
    const RegionWalk& walk = stepper.here().walk();
    const Address here = walk.at();
    const renderer::Words words = walk.plan().parts[here.part].segment.words;
    std::vector<std::size_t> starts;
    std::size_t index = 0;
    for (std::size_t at = 0; at < words.size(); at += isa::instruction_words(words[at])) {
        index = at == here.word ? starts.size() : index;
        starts.push_back(at);
    }
    const auto around = static_cast<std::size_t>(std::max(lines, 0));
    const std::size_t first = index > around ? index - around : 0;
    const std::size_t last = std::min(index + around + 1, starts.size());
    std::string text;
    for (std::size_t i = first; i < last; ++i) {
        const std::size_t at = starts[i];
        text +=
            fmt::format("{}{} {:<28} {}", i == first ? "" : "\n", i == index ? "=>" : "  ",
                        to_text(walk.plan(), {here.part, at}),
                        isa::disassemble(*isa::decode(words[at]), coefficients_behind(words, at)));
    }
    return text;
}

PictureWindow window_of_interest(const Stepper& stepper) {
    const RegionPlace& place = stepper.region().place;
    const isa::Executor& executor = stepper.here().executor();
    PictureWindow window;
    int x = region_px / 2, y = region_px / 2;
    for (int i = 0; i < region_px * region_px; ++i) {
        if (executor.enabled(i % region_px, i / region_px)) {
            x = i % region_px;
            y = i / region_px;
            break;
        }
    }
    window.x = place.x0_px + std::clamp(x - window.width / 3, 0, region_px - window.width);
    window.y = place.y0_px + std::clamp(y - 1, 0, region_px - window.height);
    return window;
}

std::string print_text(const Stepper& stepper, const NamedField& field, PictureWindow window) {
    const RegionPlace& place = stepper.region().place;
    const isa::Executor& executor = stepper.here().executor();
    const int x0 = std::clamp(window.x - place.x0_px, 0, region_px);
    const int y0 = std::clamp(window.y - place.y0_px, 0, region_px);
    const int x1 = std::clamp(window.x + window.width - place.x0_px, x0, region_px);
    const int y1 = std::clamp(window.y + window.height - place.y0_px, y0, region_px);
    if (x0 == x1 || y0 == y1) {
        throw RequestError(ExitCode::usage,
                           fmt::format("no pixel of the window at ({}, {}) is in region {}",
                                       window.x, window.y, place.number));
    }
    std::size_t width = 5;
    for (int i = 0; i < (x1 - x0) * (y1 - y0); ++i) {
        const std::uint64_t value = field.value(executor, x0 + i % (x1 - x0), y0 + i / (x1 - x0));
        width = std::max(width, fmt::formatted_size("{}", value));
    }
    std::string text = fmt::format("{} (* enabled)\n{:>6}", field.name, "y\\x");
    for (int x = x0; x < x1; ++x) {
        text += fmt::format(" {:>{}} ", place.x0_px + x, width);
    }
    for (int y = y0; y < y1; ++y) {
        text += fmt::format("\n{:>6}", place.y0_px + y);
        for (int x = x0; x < x1; ++x) {
            text += fmt::format(" {:>{}}{}", field.value(executor, x, y), width,
                                executor.enabled(x, y) ? '*' : ' ');
        }
    }
    return text;
}

Address address_of(const renderer::RegionPlan& plan, std::string_view text) {
    const std::size_t plus = text.rfind('+');
    std::size_t word = 0;
    if (plus != std::string_view::npos) {
        const char* end = text.data() + text.size();
        const auto read = std::from_chars(text.data() + plus + 1, end, word);
        for (std::size_t part = 0;
             read.ec == std::errc{} && read.ptr == end && part < plan.parts.size(); ++part) {
            const std::string begin = to_text(plan, {part, 0});
            if (text.substr(0, plus) != std::string_view(begin).substr(0, begin.rfind('+')) &&
                text.substr(0, plus) != fmt::format("{}", part)) {
                continue;
            }
            const renderer::Words words = plan.parts[part].segment.words;
            for (std::size_t at = 0; at < words.size(); at += isa::instruction_words(words[at])) {
                if (at == word) {
                    return {part, word};
                }
            }
        }
    }
    throw RequestError(
        ExitCode::usage,
        fmt::format("this region has no instruction at '{}'; addresses look like "
                    "prologue+0, end+12, '{}' or PART+WORD",
                    text, to_text(plan, {std::min<std::size_t>(1, plan.parts.size() - 1), 0})));
}

}  // namespace pxpl5::host::inspect
