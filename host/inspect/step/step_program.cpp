#include "host/inspect/step/step_program.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>

#include "host/base/error.hpp"
#include "host/inspect/map/picture_file.hpp"
#include "host/inspect/record/selection.hpp"
#include "host/inspect/step/step_view.hpp"
#include "host/inspect/step/step_words.hpp"

namespace pxpl5::host::inspect {

namespace {

constexpr std::int64_t listed_lines = 8;  ///< Around the next instruction, each way.
constexpr std::size_t png_scale = 4;      ///< A region's pixel is 4 x 4 in a PNG.
constexpr int print_columns_most = 32, print_rows_most = 64;

/// The next instruction, said to be that; or that the region is drawn.
std::string upcoming(const Stepper& stepper) {
    return (stepper.here().done() ? "" : "next ") + next_line(stepper);
}

bool stops_behind(const Break& stop) {
    return std::holds_alternative<PixelBreak>(stop) || std::holds_alternative<DepthBreak>(stop) ||
           std::holds_alternative<EmptyBreak>(stop);
}

/// Region number of "N" or "C,R" in the frame.
std::uint32_t region_number(const RecordedFrame& frame, const std::string& text) {
    SelectionText selected;
    selected.region = {text};
    const Selection selection = parse_selection(selected);
    for (const auto& [number, region] : frame.regions) {
        if (selection.has_region(number, region.place.column, region.place.row)) {
            return number;
        }
    }
    refuse(fmt::format("frame {} has no region {} that can be executed", frame.number, text));
}

}  // namespace

StepProgram::StepProgram(const RecordedRun& run, std::uint32_t frame, TerminalStyle style)
    : stepper_(run, frame), style_(style) {}

std::string StepProgram::welcome() const {
    return fmt::format(
        "Frame {}, region {}. A line tells: #instruction of the region, address (part of the "
        "region+word),\ninstruction, pixels enabled before -> after, what changed. 'help' lists "
        "the commands.\nnext {}",
        stepper_.frame().number, stepper_.region().place.number, next_line(stepper_));
}

// ---- moving

std::string StepProgram::step(const Words& words) {
    const std::int64_t times = number_or(words, 0, 1, "a count of instructions");
    if (times < 0) {
        return back({fmt::format("{}", -times)});
    }
    for (std::int64_t i = 0; i < times; ++i) {
        if (!stepper_.step()) {
            return "the run ends here; " + next_line(stepper_);
        }
    }
    return done_line(stepper_);
}

std::string StepProgram::back(const Words& words) {
    std::int64_t times = number_or(words, 0, 1, "a count of instructions");
    while (times > 0) {
        // Within a region at once.
        const std::uint64_t executed = stepper_.here().executed();
        const auto jump = static_cast<std::uint64_t>(times);
        if (executed > 0) {
            const std::uint64_t less = std::min(executed, jump);
            stepper_.go_to(
                {stepper_.frame().number, stepper_.region().place.number, executed - less});
            times -= static_cast<std::int64_t>(less);
        } else if (stepper_.back()) {
            --times;
        } else {
            return "the run begins here; " + upcoming(stepper_);
        }
    }
    return upcoming(stepper_);
}

/// Moves to the next place of one kind, `times` times; backward if negative.
std::string StepProgram::to_stops(const Break& stop, std::int64_t times, const char* what) {
    const Direction direction = times < 0 ? Direction::backward : Direction::forward;
    for (std::int64_t i = 0; i < std::abs(times); ++i) {
        if (!stepper_.run_to({&stop, 1}, direction)) {
            return fmt::format("no {} {}; {}", what,
                               direction == Direction::forward ? "follows" : "comes before",
                               next_line(stepper_));
        }
    }
    return upcoming(stepper_);
}

std::string StepProgram::primitive(const Words& words) {
    return to_stops(PrimitiveBreak{}, number_or(words, 0, 1, "a count of primitives"), "primitive");
}

std::string StepProgram::primitive_back(const Words& words) {
    return to_stops(PrimitiveBreak{}, -number_or(words, 0, 1, "a count of primitives"),
                    "primitive");
}

std::string StepProgram::part(const Words& words) {
    return to_stops(PartBreak{}, number_or(words, 0, 1, "a count of parts"), "part");
}

std::string StepProgram::region(const Words& words) {
    const std::int64_t times = number_or(words, 0, 1, "a count of regions");
    for (std::int64_t i = 0; i < std::abs(times); ++i) {
        if (!stepper_.to_region(times < 0 ? Direction::backward : Direction::forward)) {
            refuse(times < 0 ? "there is no region before" : "no region follows");
        }
    }
    return fmt::format("frame {}, region {}; {}", stepper_.frame().number,
                       stepper_.region().place.number, upcoming(stepper_));
}

std::string StepProgram::frame(const Words& words) {
    const std::int64_t times = number_or(words, 0, 1, "a count of frames");
    for (std::int64_t i = 0; i < std::abs(times); ++i) {
        if (!stepper_.to_frame(times < 0 ? Direction::backward : Direction::forward)) {
            refuse(times < 0 ? "there is no frame before" : "no frame follows");
        }
    }
    return fmt::format("frame {}, region {}; {}", stepper_.frame().number,
                       stepper_.region().place.number, upcoming(stepper_));
}

std::string StepProgram::run_to_breaks(Direction direction) {
    if (breaks_.empty()) {
        refuse("there is no breakpoint; 'break op TREEltMEM' makes one, 'help' lists the kinds");
    }
    const auto found = stepper_.run_to(breaks_, direction);
    if (!found) {
        return fmt::format("no breakpoint held; this is the run's {}: {}",
                           direction == Direction::forward ? "end" : "begin", next_line(stepper_));
    }
    const Break& stop = breaks_[*found];
    return fmt::format("frame {}, region {}: breakpoint {}, {}\n{}", stepper_.frame().number,
                       stepper_.region().place.number, break_numbers_[*found], to_text(stop),
                       stops_behind(stop) ? done_line(stepper_) : upcoming(stepper_));
}

std::string StepProgram::go_on(const Words&) {
    return run_to_breaks(Direction::forward);
}

std::string StepProgram::go_back(const Words&) {
    return run_to_breaks(Direction::backward);
}

void StepProgram::go_to_pixel(const Words& words) {
    const RegionPlace place = stepper_.frame().region_at(
        static_cast<int>(number_of(words[1], "X")), static_cast<int>(number_of(words[2], "Y")));
    stepper_.go_to({stepper_.frame().number, place.number, 0});
}

std::string StepProgram::go_to(const Words& words) {
    const RunPlace here = stepper_.place();
    const std::string what = !words.empty() ? words[0] : "";
    if (what == "region" && words.size() == 2) {
        stepper_.go_to({here.frame, region_number(stepper_.frame(), words[1]), 0});
    } else if (what == "frame" && words.size() == 2) {
        stepper_.go_to({index_of(words[1], "a frame's number"), here.region, 0});
    } else if (what == "pixel" && words.size() == 3) {
        go_to_pixel(words);
    } else if (what == "end" && words.size() == 1) {
        stepper_.go_to({here.frame, here.region, ~std::uint64_t{0}});
    } else if (words.size() == 1 && std::isdigit(static_cast<unsigned char>(what[0])) != 0 &&
               what.find('+') == std::string::npos) {
        stepper_.go_to({here.frame, here.region, index_of(what, "an instruction's number")});
    } else if (!words.empty()) {
        const Break stop =
            AddressBreak{here.region, address_of(stepper_.region().plan, joined(words, 0))};
        stepper_.go_to({here.frame, here.region, 0});
        if (std::get<AddressBreak>(stop).address != stepper_.here().walk().at()) {
            stepper_.run_to({&stop, 1}, Direction::forward);
        }
        if (stepper_.place().region != here.region || stepper_.place().frame != here.frame) {
            stepper_.go_to(here);
            refuse(fmt::format("'{}' is jumped over: it is never executed", joined(words, 0)));
        }
    } else {
        refuse("goto where? N, end, ADDRESS, region N, frame N or pixel X Y");
    }
    return upcoming(stepper_);
}

// ---- breakpoints

std::string StepProgram::add_break(const Words& words) {
    breaks_.push_back(break_of(words, stepper_));
    break_numbers_.push_back(next_break_++);
    return fmt::format("breakpoint {}: {}", break_numbers_.back(), to_text(breaks_.back()));
}

std::string StepProgram::remove_break(const Words& words) {
    if (words.empty()) {
        breaks_.clear();
        break_numbers_.clear();
        return "no breakpoint is left";
    }
    const std::int64_t number = number_of(words[0], "a breakpoint's number");
    const auto found = std::ranges::find(break_numbers_, number);
    if (found == break_numbers_.end()) {
        refuse(fmt::format("there is no breakpoint {}; 'info' lists them", number));
    }
    breaks_.erase(breaks_.begin() + (found - break_numbers_.begin()));
    break_numbers_.erase(found);
    return fmt::format("breakpoint {} is removed", number);
}

std::string StepProgram::list_breaks(const Words&) {
    std::string text;
    for (std::size_t i = 0; i < breaks_.size(); ++i) {
        text += fmt::format("{}{}: {}", i == 0 ? "" : "\n", break_numbers_[i], to_text(breaks_[i]));
    }
    return text.empty() ? "no breakpoint" : text;
}

// ---- looking

std::string StepProgram::pixel(const Words& words) {
    return pixel_text(stepper_, static_cast<int>(number_of(words[0], "X")),
                      static_cast<int>(number_of(words[1], "Y")));
}

std::string StepProgram::list(const Words& words) {
    return list_text(
        stepper_, static_cast<int>(number_or(words, 0, listed_lines, "a count of instructions")));
}

std::string StepProgram::print(const Words& words) {
    if (words.size() != 1 && words.size() != 3 && words.size() != 5) {
        refuse("print what? print FIELD, print FIELD X Y, or print FIELD X Y W H");
    }
    PictureWindow window = window_of_interest(stepper_);
    const auto number = [&](std::size_t at, int fallback, const char* what) {
        return static_cast<int>(number_or(words, at, fallback, what));
    };
    window = {number(1, window.x, "X"), number(2, window.y, "Y"),
              std::clamp(number(3, window.width, "a width"), 1, print_columns_most),
              std::clamp(number(4, window.height, "a height"), 1, print_rows_most)};
    return print_text(stepper_, field_of(words[0]), window);
}

/// The field that word `index` names. Without that word: normals while primitives are drawn, and
/// colors once the end-of-region program runs, because it overwrites the normals.
NamedField StepProgram::field_or_default(const Words& words, std::size_t index) const {
    const RegionStepper& here = stepper_.here();
    const bool shading = here.done() || here.walk().plan().parts[here.walk().at().part].kind ==
                                            PartKind::end_of_region;
    return field_of(index < words.size() ? words[index] : shading ? "rgb" : "normal");
}

std::string StepProgram::show(const Words& words) {
    const NamedField field = field_or_default(words, 0);
    const std::string text =
        terminal_text(picture_of(stepper_.here().executor(), field), region_px, style_);
    return text + fmt::format("{} of region {}", field.name, stepper_.region().place.number);
}

std::string StepProgram::png(const Words& words) {
    const NamedField field = field_or_default(words, 1);
    const std::vector<std::uint32_t> small = picture_of(stepper_.here().executor(), field);
    constexpr std::size_t side = region_px, large = side * png_scale;
    std::vector<std::uint32_t> picture(large * large);
    for (std::size_t i = 0; i < picture.size(); ++i) {
        picture[i] = small[i / large / png_scale * side + i % large / png_scale];
    }
    write_png(words[0], static_cast<int>(large), static_cast<int>(large), picture);
    return fmt::format("{}: {} of region {}, {} x {}", words[0], field.name,
                       stepper_.region().place.number, large, large);
}

std::string StepProgram::where(const Words&) {
    return where_text(stepper_);
}

std::string StepProgram::quit(const Words&) {
    is_over_ = true;
    return {};
}

}  // namespace pxpl5::host::inspect
