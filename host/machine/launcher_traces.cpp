// Launcher: what the host and its nodes record.
#include <fmt/format.h>

#include <algorithm>
#include <system_error>
#include <utility>

#include "host/base/error.hpp"
#include "host/machine/launcher.hpp"
#include "isa/table_hash.hpp"
#include "ringbus/process/process.hpp"

namespace pxpl5::host {

namespace {

namespace schema = bus::schema;
using bus::trace::TraceError;

constexpr int failed_save_ms = 1000;  // Limit after a failure, while the user waits.

}  // namespace

std::filesystem::path Launcher::trace_path(const std::string& file) const {
    return folder_ / "traces" / (file + ".mcap");
}

int Launcher::flight_share_kib() const {
    return static_cast<int>(flight_kib / roster_.size());
}

void Launcher::start_recording() {
    if (topology_.record == Recording::off) {
        return;
    }
    const std::filesystem::path folder = folder_ / "traces";
    std::error_code error;
    std::filesystem::create_directory(folder, error);
    if (error) {
        throw RequestError(ExitCode::failed,
                           fmt::format("cannot make {}: {}", folder.string(), error.message()));
    }
    bus::trace::Info info;
    info.build = bus::build_id();
    info.schema_hash = bus::schema_hash();
    info.recording = static_cast<Recording>(topology_.record);
    info.more = {{"isa_hash", std::string(isa::table_hash())},
                 {"topology", resolved_json(topology_)}};
    try {
        bus::trace::Limits limits;
        limits.share_bytes = static_cast<std::size_t>(flight_share_kib()) * 1024;
        recorder_.emplace(trace_path("host-0"), info, limits);
    } catch (const TraceError& failure) {
        throw RequestError(ExitCode::failed, failure.what());
    }
}

void Launcher::guard_recording(const std::function<void()>& act) {
    try {
        act();
    } catch (const TraceError& error) {
        record_failure_ = error.what();
    }
}

void Launcher::note(const bus::Message& message) {
    // The host sends a volume of the io process to the GPs, whose traces have it.
    if (recorder_ && message.kind() != bus::Body::Slices && !bus::is_onlookers(message.kind())) {
        guard_recording([&] { recorder_->note(message); });
    }
}

void Launcher::flush_trace() {
    if (recorder_) {
        guard_recording([this] { recorder_->idle(); });
    }
}

std::optional<MachineError> Launcher::close_trace() {
    try {
        if (recorder_) {
            recorder_->close();
        }
    } catch (const TraceError& error) {
        return MachineError(ExitCode::failed, error.what());
    }
    return std::nullopt;
}

std::set<bus::NodeId> Launcher::ask_for_traces(SavedTraces& saved) {
    saved.folder = (folder_ / "traces").string();
    const std::vector<std::string> running = processes_.running();
    const bus::Payload ask = bus::pack(schema::SaveTraceT{});
    std::set<bus::NodeId> asked;
    for (const RosterEntry& node : roster_) {
        if (std::find(running.begin(), running.end(), node.name()) != running.end()) {
            link_.send(node.id, ask);
            asked.insert(node.id);
        }
    }
    try {  // The nodes write at the same time.
        const bus::trace::Recorder::Saved own = recorder_->save();
        ++saved.nodes;
        saved.messages += own.messages;
        saved.bytes += own.bytes;
    } catch (const TraceError& error) {
        saved.missing.push_back(fmt::format("host: {}", error.what()));
    }
    return asked;
}

void Launcher::take_answer(const bus::Message& message, SavedTraces& saved) {
    const auto& answer = *message.as<schema::TraceSaved>();
    if (answer.error() != nullptr && answer.error()->size() != 0) {
        saved.missing.push_back(
            fmt::format("{}: {}", name_of(message.source()), answer.error()->str()));
        return;
    }
    ++saved.nodes;
    fetch_trace(message.source());
    saved.messages += answer.messages();
    saved.bytes += answer.bytes();
}

bool Launcher::take_trace_answer(const bus::Message& message, AwaitedTraces& awaited,
                                 SavedTraces& saved) {
    const bus::NodeId node = message.source();
    if (message.kind() == bus::Body::TraceSaved) {
        if (awaited.nodes.erase(node) != 0) {
            take_answer(message, saved);
        }
        return true;
    }
    const auto* fault = message.as<schema::Fault>();
    if (fault == nullptr || fault->request() != static_cast<int>(bus::Body::SaveTrace) ||
        !awaited.nodes.contains(node)) {
        return false;
    }
    if (awaited.asked_again.insert(node).second) {
        link_.send(node, bus::pack(schema::SaveTraceT{}));
    } else {
        awaited.nodes.erase(node);
        saved.missing.push_back(fmt::format("{}: {}", name_of(node), fault->reason()->str()));
    }
    return true;
}

SavedTraces Launcher::save_traces(int limit_ms) {
    if (over_) {
        throw *over_;
    }
    if (!recorder_) {
        throw RequestError(ExitCode::usage,
                           "nothing is recorded: start the machine with --record flight or full");
    }
    SavedTraces saved;
    AwaitedTraces awaited{ask_for_traces(saved), {}};
    const std::int64_t deadline_ms = now_ms() + limit_ms;
    while (!awaited.nodes.empty() && now_ms() < deadline_ms) {
        for (bool more = true; more && now_ms() < deadline_ms;) {
            const std::optional<bus::Message> message = take_from_link();
            more = message.has_value();
            if (message && !take_trace_answer(*message, awaited, saved)) {
                keep(*message);
            }
        }
        if (!awaited.nodes.empty()) {
            check_health();
            const std::int64_t left_ms = deadline_ms - now_ms();
            wait_for_event(wait_ms(std::max<std::int64_t>(left_ms, 0)));
        }
    }
    await_fetched(saved, deadline_ms);
    for (const bus::NodeId id : awaited.nodes) {
        saved.missing.push_back(
            fmt::format("{}: no answer within {} s", name_of(id), limit_ms / 1000));
    }
    return saved;
}

/// Must not throw: the machine is failing already, and the first cause must be reported.
std::string Launcher::traces_of_failure() {
    if (!launched_ || !recorder_) {
        return {};
    }
    SavedTraces saved;
    AwaitedTraces awaited{ask_for_traces(saved), {}};
    const std::int64_t deadline_ms = now_ms() + failed_save_ms;
    while (true) {
        for (bool more = true; more && now_ms() < deadline_ms;) {
            try {
                const std::optional<bus::Message> message = link_.receive();
                more = message.has_value();
                if (message) {
                    note(*message);
                    take_trace_answer(*message, awaited, saved);
                }
            } catch (const std::runtime_error&) {
                // This message is lost. The next may be valid.
            }
        }
        const std::vector<std::string> running = processes_.running();
        std::erase_if(awaited.nodes, [&](bus::NodeId id) {
            return std::find(running.begin(), running.end(), name_of(id)) == running.end();
        });
        const std::int64_t left_ms = deadline_ms - now_ms();
        if (awaited.nodes.empty() || left_ms <= 0) {
            break;
        }
        wait_for_event(static_cast<int>(left_ms));
    }
    return fmt::format("; traces of {} of {} nodes: {}", saved.nodes, roster_.size(), saved.folder);
}

}  // namespace pxpl5::host
