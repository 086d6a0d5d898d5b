#include "host/commands/commands.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "host/base/error.hpp"
#include "host/base/nearest.hpp"

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

namespace {

/// The row of the command, if the arguments fit it.
const Command& checked_command(const Arguments& arguments) {
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
    return command;
}

bool has_content(const Session& session) {
    return session.has_volume() || session.archive() != nullptr;
}

}  // namespace

CommandKind kind_of(const Arguments& arguments) {
    const CommandKind kind = find_command(arguments.name).kind;
    const bool takes_away = !arguments.words.empty() && arguments.words.back() == "off";
    const bool is_of_pixel = arguments.has("at");
    return kind == CommandKind::setting && (takes_away || is_of_pixel) ? CommandKind::action : kind;
}

std::string subject_of(const Arguments& arguments) {
    if (kind_of(arguments) != CommandKind::setting) {
        return {};
    }
    const Command& command = find_command(arguments.name);
    Arguments subject{arguments.name, arguments.words, {}};
    for (std::size_t i = command.subject_words; i < subject.words.size(); ++i) {
        subject.words[i] = "*";
    }
    for (const auto& option : arguments.options) {
        subject.words.push_back(option.first + "=");
    }
    return to_line(subject);
}

Reply run_command(Session& session, const Arguments& arguments, const Arguments* noted) {
    const Command& command = checked_command(arguments);
    if (command.kind == CommandKind::memory) {
        return command.run(session, arguments);
    }
    const Deed deed{to_line(noted != nullptr ? *noted : arguments), subject_of(arguments),
                    command.kind == CommandKind::action};
    const Scene before = session.scene;
    const bool had_content = has_content(session);
    try {
        Reply reply = command.run(session, arguments);
        session.history.note(deed, before, session.scene);
        if (command.name == "load") {
            session.history.begin_anew(deed.line);
        }
        return reply;
    } catch (const MachineError&) {
        throw;  // Nothing is lost that a machine started anew is not given.
    } catch (const std::exception&) {
        session.history.note_losses(before, session.scene);
        if (had_content && !has_content(session)) {
            session.history.forget_load();
        }
        throw;
    }
}

}  // namespace pxpl5::host
