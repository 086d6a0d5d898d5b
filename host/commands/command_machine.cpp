// Commands that look at the machine's inside, or break it.
#include <fmt/format.h>

#include <charconv>
#include <system_error>

#include "host/base/error.hpp"
#include "host/base/stopwatch.hpp"
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
    const RestartSettings rule = session.conversation.machine().restart_of(name);
    const bool ends = rule.policy == RestartPolicy::end || rule.max == 0;
    return {fmt::format("{} killed; the machine {}", name, ends ? "stops" : "is started again"),
            {{"node", name}}};
}

namespace {

/// The nodes to add for "+2", "-1" or the count "4" of nodes that are `now` so many.
int more_nodes(const Arguments& arguments, const std::string& role, std::size_t now) {
    if (!arguments.has(role)) {
        return 0;
    }
    const std::string& text = arguments.options.at(role);
    const bool is_change = text.starts_with('+') || text.starts_with('-');
    const char* const first = text.data() + (text.starts_with('+') ? 1 : 0);
    int number = 0;
    const auto [end, error] = std::from_chars(first, text.data() + text.size(), number);
    if (text.empty() || error != std::errc{} || end != text.data() + text.size()) {
        refuse_command(
            fmt::format("scale: {} is '{}', must be a count (4), or how many to add (+2) "
                        "or to retire (-1)",
                        role, text));
    }
    constexpr int most = max_nodes_per_role;
    const std::int64_t count = std::int64_t{number} + (is_change ? static_cast<int>(now) : 0);
    if (count < 1 || count > most) {
        refuse_command(fmt::format("scale: {} is '{}', which makes {} of {}, must make 1..{}", role,
                                   text, count, now, most));
    }
    return static_cast<int>(count) - static_cast<int>(now);
}

}  // namespace

Reply run_scale(Session& session, const Arguments& arguments) {
    const std::int64_t start_ns = now_ns();
    const NodeChange change{
        more_nodes(arguments, "gp", session.conversation.gps().size()),
        more_nodes(arguments, "renderer", session.conversation.renderer_count())};
    if (change.gps != 0 || change.renderers != 0) {
        session.scale(change);
    }
    const int gps = static_cast<int>(session.conversation.gps().size());
    const int renderers = static_cast<int>(session.conversation.renderer_count());
    const double ms = ms_since(start_ns);
    return {
        fmt::format("the machine has {}; ready after {:.0f} ms", nodes_text(gps, renderers), ms),
        {{"gps", std::int64_t{gps}}, {"renderers", std::int64_t{renderers}}, {"scale_ms", ms}}};
}

}  // namespace pxpl5::host
