#include "host/commands/commands.hpp"

#include <algorithm>
#include <iterator>

#include "host/base/error.hpp"

namespace pxpl5::host {

const Command& find_command(std::string_view name, CommandTable table) {
    return find_in(table, name);
}

namespace {

bool has_content(const Session& session) {
    return session.volumes.has_volume() || session.volumes.archive() != nullptr;
}

}  // namespace

std::vector<Fields> table_fields(CommandTable table) {
    std::vector<Fields> list;
    std::ranges::transform(table, std::back_inserter(list), descriptor_fields);
    return list;
}

CommandKind kind_of(const Arguments& arguments, CommandTable table) {
    const CommandKind kind = find_command(arguments.name, table).kind;
    const std::string last = arguments.words.empty() ? "" : arguments.words.back();
    const bool depends = last == "off" || last == "flip" || last == "next" || last == "previous" ||
                         last == "two-point" || last == "three-point" || arguments.has("at");
    return kind == CommandKind::setting && depends ? CommandKind::action : kind;
}

std::string subject_of(const Arguments& arguments, CommandTable table) {
    if (kind_of(arguments, table) != CommandKind::setting) {
        return {};
    }
    const Command& command = find_command(arguments.name, table);
    Arguments subject{arguments.name, arguments.words, {}};
    for (std::size_t i = command.subject_words; i < subject.words.size(); ++i) {
        subject.words[i] = "*";
    }
    for (const auto& option : arguments.options) {
        subject.words.push_back(option.first + "=");
    }
    return to_line(subject);
}

namespace {

void tell_opened(const Session& session, const std::string& volume) {
    if (session.tell_opened) {
        session.tell_opened(volume);
    }
}

}  // namespace

Reply run_command(Session& session, const Arguments& arguments, const Arguments* noted,
                  CommandTable table) {
    const Command& command = find_command(arguments.name, table);
    if (session.check_command) {
        session.check_command(command, arguments);
    }
    check_arguments(command, arguments);
    if (command.run == nullptr) {
        return help_reply(table, arguments);
    }
    Reply reply;
    const auto act = [&] { reply = command.run(session, arguments); };
    if (command.kind == CommandKind::memory) {
        session.recovery.run(act);
        return reply;
    }
    const Deed deed{to_line(noted != nullptr ? *noted : arguments), subject_of(arguments, table),
                    command.kind == CommandKind::action};
    const Scene before = session.scene;
    const bool had_content = has_content(session);
    try {
        session.recovery.run(act);
        session.history.note(deed, before, session.scene);
        if (command.name == "load") {
            session.history.begin_anew(deed.line);
            tell_opened(session, arguments.words.front());
        }
        return reply;
    } catch (const MachineError&) {
        throw;  // The machine has ended.
    } catch (const ContentLost&) {
        throw;  // The history knows.
    } catch (const std::exception&) {
        session.history.note_losses(before, session.scene);
        if (had_content && !has_content(session)) {
            session.history.forget_load();
            tell_opened(session, "");
        }
        throw;
    }
}

}  // namespace pxpl5::host
