// pxpl5 trace step: reads commands from the terminal, standard input or -c.
#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cstdio>
#include <iostream>

#include "host/base/error.hpp"
#include "host/base/kernel/standard_streams.hpp"
#include "host/base/prompt.hpp"
#include "host/base/text_output.hpp"
#include "host/inspect/record/find_run.hpp"
#include "host/inspect/step/step_program.hpp"
#include "host/inspect/tools/tools.hpp"

namespace pxpl5::host::inspect {

namespace {

TerminalStyle style_of_terminal() {
    TerminalStyle style;
    winsize size{};
    if (isatty(STDOUT_FILENO) != 0) {
        style.color = true;
        if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0) {
            style.columns = size.ws_col;
        }
    }
    return style;
}

/// Where commands come from.
LineSource source_of(const StepOptions& options, bool is_prompt) {
    if (!options.commands.empty()) {
        std::string text;
        for (const std::string& command : options.commands) {
            text += command + "\n";
        }
        return lines_of_text(text);
    }
    if (is_prompt) {
        return lines_of_prompt();
    }
    return [] {
        std::string line;
        return std::getline(std::cin, line) ? std::optional(line) : std::nullopt;
    };
}

/// Goes to the region that the selection names, if it names any.
void go_to_region(StepProgram& program, const SelectionText& text) {
    const Selection selection = parse_selection(text);
    const RecordedFrame& frame = program.stepper().frame();
    for (const auto& [number, region] : frame.regions) {
        if (selection.has_region(number, region.place.column, region.place.row)) {
            program.stepper().go_to({frame.number, number, 0});
            return;
        }
    }
    throw RequestError(ExitCode::usage,
                       fmt::format("frame {} has no region {} that can be executed", frame.number,
                                   text.region.empty() ? "" : text.region.front()));
}

}  // namespace

int trace_step(const StepOptions& options) {
    const bool is_prompt = options.commands.empty() && isatty(STDIN_FILENO) != 0;
    const RecordedRun run = open_run(options.run);
    SelectionText frames;
    frames.frame = options.selection.frame;
    StepProgram program(run, one_frame(run, frames), style_of_terminal());
    go_to_region(program, options.selection);
    TextOutput output("");
    output.line(program.welcome());
    const LineSource next_line = source_of(options, is_prompt);
    std::string last_move;
    while (!program.is_over()) {
        output.flush();
        std::optional<std::string> line = next_line();
        if (!line) {
            break;
        }
        if (is_prompt && line->find_first_not_of(" \t") == std::string::npos) {
            line = last_move;
        }
        last_move = StepProgram::is_move(*line) ? *line : "";
        try {
            const std::string answer = program.command(*line);
            if (!answer.empty()) {
                output.raw(answer + "\n");  // Pictures have the escape codes of colors.
            }
        } catch (const RequestError& error) {
            output.flush();
            const int code = print_error(error.what(), static_cast<int>(error.code));
            if (!is_prompt) {
                return code;
            }
        }
    }
    output.finish();
    return 0;
}

}  // namespace pxpl5::host::inspect
