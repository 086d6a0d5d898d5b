#include "host/machine/sessions/sessions_cli.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host/base/kernel/standard_streams.hpp"
#include "host/base/state_folder.hpp"
#include "host/base/text_table.hpp"
#include "host/machine/sessions/session_end.hpp"
#include "host/machine/sessions/session_list.hpp"

namespace pxpl5::host {

namespace {

struct SessionsFlags {
    std::string base = default_run_base().string(), name;
    bool json = false;
    int limit_s = 15;  // The host ends the last process of a machine within 10 s.
};

/// "-" for what is not known.
std::string shown(const std::string& text) {
    return text.empty() ? "-" : printable(text);
}

std::string memory_text(const RunningSession& session) {
    constexpr double bytes_per_mib = 1 << 20;
    return session.memory_bytes
               ? fmt::format("{:.0f} MiB",
                             static_cast<double>(*session.memory_bytes) / bytes_per_mib)
               : "-";
}

std::string viewers_text(const RunningSession& session) {
    return session.facts.url.empty() ? "-" : fmt::format("{}", session.facts.viewers);
}

/// `with_addresses`  Also the addresses with their tokens.
nlohmann::ordered_json json_of(const RunningSession& session, bool with_addresses) {
    nlohmann::ordered_json json{{"name", session.name},
                                {"folder", session.folder.string()},
                                {"subcommand", session.subcommand},
                                {"state", session.state},
                                {"started", session.started},
                                {"volume", session.facts.volume},
                                {"computer", session.computer},
                                {"here", session.is_here},
                                {"pid", session.pid},
                                {"job", session.job},
                                {"memory_bytes", nullptr},
                                {"viewers", nullptr}};
    if (session.memory_bytes) {
        json["memory_bytes"] = *session.memory_bytes;
    }
    if (!session.facts.url.empty()) {
        json["viewers"] = session.facts.viewers;
    }
    if (with_addresses) {
        json["url"] = session.facts.url;
        json["watch_url"] = session.facts.watch_url;
        json["tunnel"] = session.facts.tunnel;
        json["ends_at"] = session.facts.ends_at;
        json["saved"] = session.facts.saved;
    }
    return json;
}

void print(const nlohmann::ordered_json& json) {
    // Names of files need not be UTF-8.
    fmt::print("{}\n", json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
}

void list(const SessionsFlags& flags) {
    const std::vector<RunningSession> sessions = running_sessions(flags.base);
    if (flags.json) {
        nlohmann::ordered_json all = nlohmann::ordered_json::array();
        for (const RunningSession& each : sessions) {
            all.push_back(json_of(each, false));
        }
        print({{"sessions", all}});
        return;
    }
    if (sessions.empty()) {
        fmt::print("no session runs with its run folder in {}\n", printable(flags.base));
        return;
    }
    std::vector<TableRow> rows;
    for (const RunningSession& each : sessions) {
        rows.push_back({shown(each.name), shown(each.subcommand), each.state, shown(each.started),
                        shown(each.facts.volume), shown(each.computer), shown(each.job),
                        fmt::format("{}", each.pid), memory_text(each), viewers_text(each)});
    }
    constexpr std::size_t texts = 7;
    fmt::print("{}", text_table({"name", "command", "state", "since", "volume", "computer", "job",
                                 "process", "memory", "viewers"},
                                rows, texts));
}

void show(const SessionsFlags& flags) {
    const RunningSession session = find_session(flags.base, flags.name);
    if (flags.json) {
        print(json_of(session, true));
        return;
    }
    const auto line = [](const char* key, const std::string& value) {
        if (!value.empty() && value != "-") {
            fmt::print("{:<9} {}\n", key, printable(value));
        }
    };
    line("session", session.name);
    line("command", session.subcommand);
    line("state", session.state);
    line("since", session.started);
    line("volume", session.facts.volume);
    line("computer", session.computer);
    line("process", fmt::format("{}", session.pid));
    line("job", session.job);
    line("memory", memory_text(session));
    line("viewers", viewers_text(session));
    line("folder", session.folder.string());
    line("ends", session.facts.ends_at);
    line("saved", session.facts.saved);
    line("open", session.facts.url);
    line("to watch", session.facts.watch_url);
    if (!session.facts.tunnel.empty()) {
        fmt::print("from another computer: {}, then open the same address there\n",
                   printable(session.facts.tunnel));
    }
}

void end(const SessionsFlags& flags) {
    constexpr int ms_per_s = 1000;
    const RunningSession session = find_session(flags.base, flags.name);
    const int took_ms = end_session(session, flags.limit_s * ms_per_s);
    if (flags.json) {
        print({{"name", session.name}, {"ended", true}, {"ms", took_ms}});
    } else {
        fmt::print("{} has ended after {:.1f} s\n", printable(session.name),
                   static_cast<double>(took_ms) / ms_per_s);
    }
}

}  // namespace

std::function<std::optional<int>()> declare_sessions(CLI::App& app) {
    const auto flags = std::make_shared<SessionsFlags>();
    CLI::App* const all =
        app.add_subcommand("sessions", "List, find again and end running sessions");
    CLI::App* const one = all->add_subcommand("show", "Print how to open a session again");
    CLI::App* const ended = all->add_subcommand("end", "End a session in order");
    for (CLI::App* each : {all, one, ended}) {
        each->add_option("--run-folder", flags->base,
                         "Parent directory of the run folders; $XDG_STATE_HOME/pxpl5 by default");
        each->add_flag("--json", flags->json, "Print one JSON object");
    }
    for (CLI::App* each : {one, ended}) {
        each->add_option("name", flags->name,
                         "Name of the session, its process id or job id; 'latest' is the newest")
            ->required();
    }
    ended->add_option("--timeout", flags->limit_s, "Seconds to wait for the end")
        ->check(CLI::Range(1, 600))
        ->capture_default_str();
    all->require_subcommand(0, 1);
    return [all, one, ended, flags]() -> std::optional<int> {
        if (!all->parsed()) {
            return std::nullopt;
        }
        one->parsed() ? show(*flags) : ended->parsed() ? end(*flags) : list(*flags);
        return 0;
    };
}

}  // namespace pxpl5::host
