// Commands that look at the machine's inside, or break it.
#include <fmt/format.h>

#include <array>
#include <charconv>
#include <string_view>
#include <system_error>
#include <vector>

#include "host/base/error.hpp"
#include "host/base/stopwatch.hpp"
#include "host/commands/command_handlers.hpp"
#include "host/commands/text/activity_text.hpp"

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
    Reply reply{
        fmt::format("the machine has {}; ready after {:.0f} ms", nodes_text(gps, renderers), ms),
        {{"gps", std::int64_t{gps}}, {"renderers", std::int64_t{renderers}}, {"scale_ms", ms}}};
    for (const Surface& surface : session.scene.surfaces) {
        if (!session.surfaces.has_report(surface.name)) {
            continue;
        }
        const SurfaceReport& report = session.surfaces.report_of(surface.name);
        if (report.slabs_left_out > 0) {
            add_warning(reply, fmt::format("surface {}: {}", surface.name, left_out_text(report)));
        }
    }
    return reply;
}

namespace {

std::string_view use_name(ComputerUse use) {
    constexpr std::array<std::string_view, 4> names = {"used", "idle", "lost", "released"};
    return names.at(static_cast<std::size_t>(use));
}

std::string computers_text(const std::vector<MachineComputer>& computers) {
    std::string text;
    for (const MachineComputer& each : computers) {
        text += fmt::format("{}{:<16} {:<8} {:>3} core{}  {:>3} node{}{}", text.empty() ? "" : "\n",
                            each.name, use_name(each.use), each.cores, each.cores == 1 ? " " : "s",
                            each.nodes, each.nodes == 1 ? " " : "s",
                            each.use == ComputerUse::lost ? "  " + each.why : "");
    }
    return text.empty() ? "all nodes run on this computer" : text;
}

Reply computers_reply(const std::vector<MachineComputer>& computers) {
    std::vector<Fields> list;
    for (const MachineComputer& each : computers) {
        list.push_back({{"name", each.name},
                        {"state", std::string(use_name(each.use))},
                        {"cores", std::int64_t{each.cores}},
                        {"nodes", std::int64_t{each.nodes}}});
        if (each.use == ComputerUse::lost) {
            list.back().push_back({"why", each.why});
        }
    }
    return {computers_text(computers), {{"computers", list}}};
}

}  // namespace

Reply run_computers(Session& session, const Arguments& arguments) {
    MachinePort& machine = session.conversation.machine();
    const std::string action = arguments.words.empty() ? "" : arguments.words[0];
    const std::string name = arguments.words.size() < 2 ? "" : arguments.words[1];
    if (action == "invite") {
        const std::string line = machine.join_line();
        Reply reply = computers_reply(machine.computers());
        reply.text = "run on the other computer, with a copy of the key file: " + line;
        reply.fields.push_back({"join", line});
        return reply;
    }
    if (action == "use") {
        machine.use_computers(name);
        session.scale({});
    } else if (action == "release") {
        if (name.empty()) {
            refuse_command("computers: release needs the name of a computer");
        }
        if (machine.release_computer(name)) {
            session.scale({});
        }
    }
    return computers_reply(machine.computers());
}

}  // namespace pxpl5::host
