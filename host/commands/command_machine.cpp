// Commands that look at the machine's inside, or break it.
#include <fmt/format.h>

#include "host/commands/command_handlers.hpp"
#include "host/session/activity_text.hpp"

namespace pxpl5::host {

Reply run_activity(Session& session, const Arguments&) {
    const ActivityReport report = session.nodes.activity(AwaitAnswers::all);
    return {activity_text(report), activity_fields(report, session.frames.last())};
}

Reply run_kill(Session& session, const Arguments& arguments) {
    const std::string& name = arguments.words[0];
    session.nodes.kill(name);
    return {fmt::format("{} killed; the machine will stop at the next command", name),
            {{"node", name}}};
}

}  // namespace pxpl5::host
