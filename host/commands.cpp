#include "host/commands.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "host/error.hpp"
#include "host/nearest.hpp"

namespace pxpl5::host {

const Command& find_command(std::string_view name) {
    std::vector<std::string_view> names;
    for (const Command& command : command_table()) {
        if (command.name == name) {
            return command;
        }
        names.push_back(command.name);
    }
    throw RequestError(ExitCode::usage,
                       fmt::format("there is no command '{}'{}", name, did_you_mean(name, names)));
}

Reply run_command(Session& session, const Arguments& arguments) {
    const Command& command = find_command(arguments.name);
    if (arguments.words.size() < command.min_words || arguments.words.size() > command.max_words) {
        throw RequestError(ExitCode::usage,
                           fmt::format("{} takes {}{} word(s), {} given; usage: {} {}",
                                       command.name, command.min_words,
                                       command.max_words == command.min_words
                                           ? std::string()
                                           : fmt::format(" to {}", command.max_words),
                                       arguments.words.size(), command.name, command.arguments));
    }
    for (const auto& [key, value] : arguments.options) {
        if (std::find(command.options.begin(), command.options.end(), key) ==
            command.options.end()) {
            throw RequestError(
                ExitCode::usage,
                fmt::format("{} knows no option '{}={}'{}", command.name, key, value,
                            command.options.empty() ? "; it takes none"
                                                    : did_you_mean(key, command.options)));
        }
    }
    return command.run(session, arguments);
}

}  // namespace pxpl5::host
