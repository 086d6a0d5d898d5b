#include "host/inspect/step/step_program.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <iterator>

#include "host/base/command_descriptor.hpp"
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
constexpr double max_count = 1e9;

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

struct StepProgram::Command : CommandDescriptor {
    std::string (StepProgram::*run)(const Words&) = nullptr;
    bool moves = false;
};

namespace {

/// "[N]": a count, negative where the other direction makes sense.
Parameter count_word(std::string_view help) {
    return whole_value("N", "N", -max_count, max_count, help, "1");
}

CommandDescriptor move_of(std::string_view name, std::string_view help, std::string_view counted,
                          std::vector<std::string_view> aliases = {}) {
    CommandDescriptor command{.name = name, .help = help, .aliases = std::move(aliases)};
    if (!counted.empty()) {
        command.words = {count_word(counted)};
    }
    return command;
}

/// Words of a command whose forms are checked by its function.
CommandDescriptor free_words(std::string_view name, std::string_view help, std::string_view forms,
                             std::size_t required, std::size_t most) {
    return {.name = name,
            .help = help,
            .words = std::vector<Parameter>(most),
            .required = required,
            .forms = forms};
}

}  // namespace

std::vector<StepProgram::Command> StepProgram::move_commands() {
    using P = StepProgram;
    return {
        {move_of("s", "one instruction forward, or N", "instructions", {"step"}), &P::step, true},
        {move_of("b", "one instruction back, or N", "instructions", {"back"}), &P::back, true},
        {move_of("t", "to the next primitive (triangle)", "primitives", {"triangle"}),
         &P::primitive, true},
        {move_of("T", "back to the begin of this primitive, then of those before", "primitives"),
         &P::primitive_back, true},
        {move_of("part", "to the next part: segment or end-of-region program; -1: back", "parts"),
         &P::part, true},
        {move_of("region", "to the next region; -1: back", "regions"), &P::region, true},
        {move_of("frame", "to the next frame; -1: back", "frames"), &P::frame, true},
        {move_of("c", "forward to the next breakpoint", "", {"continue"}), &P::go_on, true},
        {move_of("rc", "back to the breakpoint before", ""), &P::go_back, true},
        {free_words("goto",
                    "N (instruction of the region), end, ADDRESS, region N or C,R, frame N, pixel "
                    "X Y",
                    "PLACE", 1, 3),
         &P::go_to},
    };
}

std::vector<StepProgram::Command> StepProgram::look_commands() {
    using P = StepProgram;
    return {
        {free_words("break",
                    "op TREE* | pixel X Y | z X Y < V | empty | cell I,J,K | primitive N | at "
                    "ADDRESS",
                    "WHAT", 1, 5),
         &P::add_break},
        {free_words("delete", "remove breakpoint N, or all", "[N]", 0, 1), &P::remove_break},
        {free_words("info", "list the breakpoints", "", 0, 0), &P::list_breaks},
        {free_words("pixel", "all fields of a pixel of the picture", "X Y", 2, 2), &P::pixel},
        {free_words("print", "a field's values in a window of the picture", "FIELD [X Y [W H]]", 1,
                    5),
         &P::print},
        {free_words("show", "the region as a picture, in the terminal", "[FIELD]", 0, 1), &P::show},
        {free_words("png", "the region as a picture, in a file", "FILE [FIELD]", 1, 2), &P::png},
        {free_words("list", "instructions around the next one", "[N]", 0, 1), &P::list},
        {free_words("where", "frame, region, counts, primitive, meaning of the next instruction",
                    "", 0, 0),
         &P::where},
        {free_words("help", "this list, or one command", "[COMMAND]", 0, 1), &P::help},
        {move_of("quit", "end the program", "", {"q"}), &P::quit},
    };
}

std::span<const StepProgram::Command> StepProgram::commands() {
    static const std::vector<Command> list = [] {
        std::vector<Command> all = move_commands();
        std::ranges::move(look_commands(), std::back_inserter(all));
        return all;
    }();
    return list;
}

StepProgram::StepProgram(const RecordedRun& run, std::uint32_t frame, TerminalStyle style)
    : stepper_(run, frame), style_(style) {}

std::string StepProgram::welcome() const {
    return fmt::format(
        "Frame {}, region {}. A line tells: #instruction of the region, address (part of the "
        "region+word),\ninstruction, pixels enabled before -> after, what changed. 'help' lists "
        "the commands.\nnext {}",
        stepper_.frame().number, stepper_.region().place.number, next_line(stepper_));
}

std::string StepProgram::command(const std::string& line) {
    const Arguments arguments = parse_line(line);
    if (arguments.name.empty()) {
        return {};
    }
    const Command& command = find_in(commands(), arguments.name);
    check_arguments(command, arguments);
    return (this->*command.run)(arguments.words);
}

bool StepProgram::is_move(const std::string& line) {
    const Command* command = known_command(commands(), parse_line(line).name);
    return command != nullptr && command->moves;
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

/// To the next place of one kind, `times` over; backward if negative.
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

/// The field that word `index` names. Else what is there to be seen: normals while primitives are
/// drawn; colours once the end-of-region program, which uses up the normals, runs.
NamedField StepProgram::field_or_default(const Words& words, std::size_t index) const {
    const RegionStepper& here = stepper_.here();
    const bool shading = here.done() || here.walk().plan().parts[here.walk().at().part].kind ==
                                            renderer::RegionPlan::Kind::end_of_region;
    return field_of(index < words.size() ? words[index] : shading ? "rgb" : "normal");
}

std::string StepProgram::show(const Words& words) {
    const NamedField field = field_or_default(words, 0);
    const std::string text =
        terminal_text(picture_of(stepper_.here().executor(), field), isa::region::size_px, style_);
    return text + fmt::format("{} of region {}", field.name, stepper_.region().place.number);
}

std::string StepProgram::png(const Words& words) {
    const NamedField field = field_or_default(words, 1);
    const std::vector<std::uint32_t> small = picture_of(stepper_.here().executor(), field);
    constexpr std::size_t side = isa::region::size_px, large = side * png_scale;
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

std::string StepProgram::help(const Words& words) {
    if (!words.empty()) {
        return full_help(find_in(commands(), words[0]));
    }
    std::string text;
    for (const Command& command : commands()) {
        text += fmt::format("  {:<24} {}\n", usage_of(command), command.help);
    }
    return text +
           "X Y count over the whole picture from its top left. FIELD is enable, carry, surface, "
           "z, normal,\nnx, ny, nz, rgb, or bits as 64:24. ADDRESS is as lines show it, or "
           "PART+WORD. An empty line\nrepeats the last move. Breakpoints op, cell, primitive and "
           "at stop ahead of the instruction;\npixel, z and empty behind the one that did it.";
}

std::string StepProgram::quit(const Words&) {
    is_over_ = true;
    return {};
}

}  // namespace pxpl5::host::inspect
