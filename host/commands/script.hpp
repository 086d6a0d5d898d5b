// Runs commands one after another, from a script, from -c or from the prompt, and prints the
// answers.
#pragma once

#include <cstddef>
#include <string>

#include "host/base/prompt.hpp"
#include "host/commands/commands.hpp"
#include "host/machine/port.hpp"
#include "host/session/session.hpp"

namespace pxpl5::host {

struct ScriptOptions {
    bool json = false;        ///< One JSON object per command and line, instead of text.
    bool echo = false;        ///< Print each command before its answer.
    bool keep_going = false;  ///< Go on after a failed command, as a prompt does.
    bool strict = false;      ///< A command that gives a warning fails with exit code 3.
    bool is_prompt = false;   ///< Ctrl-C cancels the command under way and not the session.
    CommandTable table = command_table();
};

/// Longest line that is read: more without a newline is not a script.
inline constexpr std::size_t max_line_bytes = std::size_t{1} << 20;

/// Lines of `fd`, which may be a pipe: while none is here, the machine is looked after. The source
/// throws MachineError as MachinePort::wait_readable(), and RequestError if reading fails
/// (bad_data) or a line is longer than max_line_bytes.
LineSource lines_of(int fd, MachinePort& machine);
/// Lines of a file or named pipe. Throws RequestError (bad_data) if it cannot be opened.
LineSource lines_of_file(const std::string& path, MachinePort& machine);
/// Lines that a person types at the prompt. Serves `machine` while nothing is typed: Ctrl-C and
/// dead nodes then end the run, as during a command.
LineSource lines_of_prompt(MachinePort& machine);

/// Runs until the lines end or "quit". Answers go to standard output, errors to standard error
/// (with json both to standard output).
///
/// Returns   0, or the exit code of the first command that failed.
/// Throws    MachineError if the machine ends (with json, after the object of the command under
///           way, or one without a command), RequestError (failed) if
///           standard output cannot be written. A closed pipe is no error: the commands are still
///           run.
int run_script(Session& session, const LineSource& next_line, const ScriptOptions& options);

}  // namespace pxpl5::host
