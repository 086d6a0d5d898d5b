// The commands: one table of descriptors that serves the prompt, script files, -c, `render`, JSON
// and the page.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host/base/command_descriptor.hpp"
#include "host/base/command_line.hpp"
#include "host/base/reply.hpp"
#include "host/session/session.hpp"

namespace pxpl5::host {

/// One row of the table.
struct Command : CommandDescriptor {
    Reply (*run)(Session&, const Arguments&) = nullptr;  ///< Null: `help`, which needs the table.
};

using CommandTable = std::span<const Command>;

CommandTable command_table();

/// The row of that name. Throws RequestError (usage) with the nearest name.
const Command& find_command(std::string_view name, CommandTable table = command_table());

/// The row's kind. Three settings are actions: one whose last word is "off", because it may remove
/// what other settings depend on, one that ends with "flip", and one of what a pixel shows (at=),
/// because these depend on everything before them.
CommandKind kind_of(const Arguments& arguments, CommandTable table = command_table());

/// The subject of a setting: a later setting of the same subject replaces an earlier one. Empty if
/// the command is no setting.
std::string subject_of(const Arguments& arguments, CommandTable table = command_table());

/// The descriptors of all commands: for `help` with JSON and for the page.
std::vector<Fields> table_fields(CommandTable table = command_table());

/// Checks the arguments against the row, runs it, and notes the change in the session's history.
/// If a node dies, the machine is started again, and the command runs again: see Recovery.
/// Throws RequestError, MachineError.
///
/// noted  The command to note in the history, if it differs from the command to run.
Reply run_command(Session& session, const Arguments& arguments, const Arguments* noted = nullptr,
                  CommandTable table = command_table());

/// True for the command that ends a session.
inline bool is_quit(const Arguments& arguments) {
    return arguments.name == "quit";
}

}  // namespace pxpl5::host
