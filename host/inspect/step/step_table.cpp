// The table of the stepper's commands, with help and dispatch.
#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "host/base/command_descriptor.hpp"
#include "host/inspect/step/step_program.hpp"

namespace pxpl5::host::inspect {

struct StepProgram::Command : CommandDescriptor {
    std::string (StepProgram::*run)(const Words&) = nullptr;
    bool moves = false;
};

namespace {

constexpr double max_count = 1e9;

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

}  // namespace pxpl5::host::inspect
