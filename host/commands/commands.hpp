// The commands: one table that serves the prompt, script files, -c and JSON.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host/base/command_line.hpp"
#include "host/base/reply.hpp"
#include "host/session/session.hpp"

namespace pxpl5::host {

/// What a command does to the session, in so far as who has several to do must know it.
enum class CommandKind : std::uint8_t {
    question,  ///< Changes nothing, unless an option says so.
    setting,   ///< A later one of the same subject makes an earlier one superfluous.
    action,    ///< Everything else: what is before it must be done before it.
    memory     ///< Acts on what was done, and is itself no part of it.
};

/// One row of the table.
struct Command {
    std::string_view name;
    std::string_view arguments;  ///< As shown in help.
    std::string_view help;       ///< One sentence.
    std::size_t min_words, max_words;
    std::vector<std::string_view> options;  ///< Keys allowed in key=value.
    Reply (*run)(Session&, const Arguments&);
    CommandKind kind = CommandKind::question;
    std::size_t subject_words = 0;  ///< How many words say what is set, as a surface's name.
};

std::span<const Command> command_table();

/// The row of that name. Throws RequestError (usage) with the nearest name.
const Command& find_command(std::string_view name);

/// The row's kind; but a setting whose last word is "off" is an action, since it may take away what
/// others follow, and so is one of what a pixel shows (at=), which depends on all before it.
CommandKind kind_of(const Arguments& arguments);

/// What a setting sets: of two with one subject, the later leaves nothing of the earlier. Empty if
/// it is no setting.
std::string subject_of(const Arguments& arguments);

/// Checks the arguments against the row, runs it, and notes in the session's history what that
/// changed. Throws RequestError, MachineError.
///
/// noted  What stands in the history, if that is not what is run.
Reply run_command(Session& session, const Arguments& arguments, const Arguments* noted = nullptr);

/// True for the command that ends a session.
inline bool is_quit(const Arguments& arguments) {
    return arguments.name == "quit";
}

}  // namespace pxpl5::host
