// The commands: one table that serves the prompt, script files, -c and JSON.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host/command_line.hpp"
#include "host/reply.hpp"
#include "host/session.hpp"

namespace pxpl5::host {

/// One row of the table.
struct Command {
    std::string_view name;
    std::string_view arguments;  ///< As shown in help.
    std::string_view help;       ///< One sentence.
    std::size_t min_words, max_words;
    std::vector<std::string_view> options;  ///< Keys allowed in key=value.
    Reply (*run)(Session&, const Arguments&);
};

std::span<const Command> command_table();

/// The row of that name. Throws RequestError (usage) with the nearest name.
const Command& find_command(std::string_view name);

/// Checks the arguments against the row and runs it. Throws RequestError, MachineError.
Reply run_command(Session& session, const Arguments& arguments);

/// True for the command that ends a session.
inline bool is_quit(const Arguments& arguments) {
    return arguments.name == "quit";
}

}  // namespace pxpl5::host
