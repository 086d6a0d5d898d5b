// Runs commands one after another, from a script, from -c or from the prompt, and prints the
// answers.
#pragma once

#include <functional>
#include <istream>
#include <optional>
#include <string>
#include <vector>

#include "host/command_line.hpp"
#include "host/session.hpp"

namespace pxpl5::host {

struct ScriptOptions {
    bool json = false;        ///< One JSON object per command and line, instead of text.
    bool echo = false;        ///< Print each command before its answer.
    bool keep_going = false;  ///< Go on after a failed command, as a prompt does.
};

/// Gives the next command line, or nothing at the end.
using LineSource = std::function<std::optional<std::string>()>;

LineSource lines_of(std::istream& stream);
/// Lines of `text`, which are separated by ';' or newlines outside quotes.
LineSource lines_of_text(const std::string& text);
/// Asks at the terminal, with history and editing.
LineSource lines_of_prompt();

/// Runs until the lines end or "quit". Answers go to standard output, errors to standard error
/// (with json both to standard output).
///
/// Returns   0, or the exit code of the first command that failed.
/// Throws    MachineError if the machine ends.
int run_script(Session& session, const LineSource& next_line, const ScriptOptions& options);

}  // namespace pxpl5::host
