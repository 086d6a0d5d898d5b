#include "host/machine/heartbeat.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <utility>

namespace pxpl5::host {

namespace {

using bus::Body;
using bus::Phase;

constexpr std::int64_t suspect_intervals = 2;
constexpr std::int64_t ms_per_s = 1000;
constexpr std::int64_t starved_share = 10;  // One ms in ten counts as silence: it is limited, too.
constexpr std::uint64_t busy_ns = 1'000'000;  // The beat itself takes a tenth of this.

/// The words for the work that a message of this kind asks for; empty for other kinds.
std::string_view verb_of(Body kind) {
    switch (kind) {
        case Body::SetSurface:
            return "building";
        case Body::FetchMesh:
            return "sending the mesh of";
        case Body::VolumeHeader:
            return "reading slices from the volume's file";
        case Body::Slices:
            return "storing or sending slices";
        case Body::VolumeEnd:
        case Body::ImportVolume:
            return "reading a volume";
        case Body::ScenePart:
        case Body::SceneEnd:
            return "storing a scene";
        case Body::MeasureIsovalues:
            return "measuring isovalues";
        case Body::FetchVoxels:
            return "sending values of voxels";
        case Body::BeginFrame:
        case Body::RegionPrograms:
            return "drawing";
        case Body::ExportPicture:
            return "writing pictures";
        case Body::ExportMesh:
            return "writing a mesh";
        case Body::ReadMesh:
            return "reading a mesh";
        case Body::ReadArchive:
            return "reading an archive";
        default:
            return {};
    }
}

std::string subject_text(const bus::Doing& doing, const NameOfSurface& name_of_surface) {
    if (doing.kind == Body::SetSurface || doing.kind == Body::FetchMesh) {
        const std::string name = name_of_surface ? name_of_surface(doing.subject) : "";
        return name.empty() ? fmt::format(" surface {}", doing.subject)
                            : fmt::format(" surface '{}'", name);
    }
    if (doing.kind == Body::BeginFrame || doing.kind == Body::RegionPrograms) {
        return fmt::format(" frame {}", doing.subject);
    }
    return {};
}

/// "slab 3 of 12": the piece under way, counted from 1.
std::string piece_text(const bus::Doing& doing) {
    if (doing.total == 0) {
        return {};
    }
    const char* piece = doing.kind == Body::RegionPrograms                               ? "region"
                        : doing.kind == Body::Slices || doing.kind == Body::VolumeHeader ? "slice"
                                                                                         : "slab";
    return fmt::format(" ({} {} of {})", piece,
                       std::min<std::uint64_t>(doing.done + std::uint64_t{1}, doing.total),
                       doing.total);
}

/// The state by the kernel of a process or thread, for example 'T' for stopped; ' ' if it is
/// unknown. `folder`: its folder in /proc.
char state_in(const std::string& folder) {
    std::ifstream file(folder + "/stat");
    std::string line;
    std::getline(file, line);
    const std::size_t name_end = line.rfind(") ");
    return name_end == std::string::npos ? ' ' : line[name_end + 2];
}

char state_of(int pid) {
    return pid == 0 ? ' ' : state_in(fmt::format("/proc/{}", pid));
}

/// Whether the thread that beats could run, but the kernel has given the processors to others.
bool is_starved(int pid, int beater) {
    return pid != 0 && beater > 0 && state_in(fmt::format("/proc/{}/task/{}", pid, beater)) == 'R';
}

std::string state_text(char state) {
    switch (state) {
        case 'T':
            return "; the process is stopped (SIGSTOP)";
        case 'D':
            return "; the process waits for a disk or for memory";
        default:
            return {};
    }
}

std::string seconds(std::int64_t ms) {
    return fmt::format("{:.1f} s", static_cast<double>(ms) / ms_per_s);
}

}  // namespace

bool is_idle(const bus::PulseReading& pulse) {
    return pulse.phase != Phase::receiving && pulse.doing.kind == Body::NONE;
}

std::string work_text(const bus::PulseReading& pulse, const NameOfSurface& name_of_surface) {
    const std::string_view verb = verb_of(pulse.doing.kind);
    if (is_idle(pulse)) {
        return "while it waited for messages";
    }
    if (pulse.phase == Phase::receiving || verb.empty()) {
        return fmt::format("while it took {}", bus::kind_name(pulse.doing.kind));
    }
    return fmt::format("while {}{}{}{}", verb, subject_text(pulse.doing, name_of_surface),
                       piece_text(pulse.doing),
                       pulse.phase == Phase::waiting ? ", as it waited for messages" : "");
}

std::string io_work_text(const bus::PulseReading& pulse) {
    return is_idle(pulse) ? "while it had no request" : work_text(pulse, {});
}

int Heartbeat::prepare(const std::string& name) {
    Node& node = nodes_[name];
    node = {};
    node.cell = std::make_unique<bus::PulseCell>();
    return node.cell->fd();
}

void Heartbeat::watch(const Watched& process, std::int64_t now_ms) {
    Node& node = nodes_.at(process.name);
    node.process = process;
    node.cell->close_fd();
    node.is_watched = true;
    looked_ms_ = looked_ms_.value_or(now_ms);
}

void Heartbeat::take(const std::string& name, const bus::PulseNumbers& pulse) {
    if (const auto found = nodes_.find(name); found != nodes_.end()) {
        found->second.cell->set(pulse);
    }
}

const bus::PulseCell* Heartbeat::cell_of(const std::string& name) const {
    const auto found = nodes_.find(name);
    return found == nodes_.end() ? nullptr : found->second.cell.get();
}

int Heartbeat::due_ms(std::int64_t now_ms) const {
    if (!is_on()) {
        return -1;
    }
    const std::int64_t due = looked_ms_.value_or(now_ms) + settings_.interval_ms - now_ms;
    return static_cast<int>(std::clamp<std::int64_t>(due, 1, settings_.interval_ms));
}

std::vector<Heartbeat::Finding> Heartbeat::look(std::int64_t now_ms) {
    std::vector<Finding> findings;
    if (!is_on() || (looked_ms_ && now_ms - *looked_ms_ < settings_.interval_ms)) {
        return findings;
    }
    // If the host itself was away, a node is not silent for longer than the host has looked.
    const std::int64_t since_ms = looked_ms_ ? now_ms - *looked_ms_ : 0;
    const bool was_away = since_ms >= suspect_intervals * settings_.interval_ms;
    const std::int64_t passed_ms = was_away ? settings_.interval_ms : since_ms;
    looked_ms_ = now_ms;
    works_ = false;
    for (auto& [name, node] : nodes_) {
        if (auto finding = judge(node, passed_ms)) {
            findings.push_back(std::move(*finding));
        }
    }
    const bool is_quiet = std::exchange(waits_, false) && !works_;
    quiet_ms_ = is_quiet ? quiet_ms_ + passed_ms : 0;
    return findings;
}

std::optional<Heartbeat::Finding> Heartbeat::judge(Node& node, std::int64_t passed_ms) {
    const bus::PulseReading now = node.cell->read();
    const bus::PulseReading last = std::exchange(node.last, now);
    // A process may take its time to start, for example to load its libraries, unless it is
    // stopped.
    const bool starts = now.beats == 0 && state_of(node.process.pid) != 'T';
    if (!node.is_watched || node.is_done || starts) {
        works_ = true;  // A process that starts will still answer.
        return std::nullopt;
    }
    const bool has_beaten = now.beats != last.beats;
    const bool has_moved =
        now.progress != last.progress || (node.process.is_io && now.cpu_ns - last.cpu_ns > busy_ns);
    const bool waits_for_processor = !has_beaten && is_starved(node.process.pid, now.beater);
    node.silent_ms = has_beaten            ? 0
                     : waits_for_processor ? node.silent_ms + passed_ms / starved_share
                                           : node.silent_ms + passed_ms;
    node.still_ms = has_moved ? 0 : node.still_ms + (has_beaten ? passed_ms : 0);
    works_ |= !has_beaten || now.worked != last.worked || now.phase != Phase::waiting;
    node.is_suspect &= !has_beaten;
    const auto finding = [&](const std::string& fact, bool is_dead, bool is_stopped = false) {
        node.is_done |= is_dead;
        return Finding{node.process.name,
                       fmt::format("{} (process {}) {}", node.process.name, node.process.pid, fact),
                       is_dead, is_stopped};
    };
    const std::string work =
        node.process.is_io ? io_work_text(now) : work_text(now, name_of_surface_);
    if (settings_.stuck_s > 0 && node.still_ms >= ms_per_s * settings_.stuck_s) {
        return finding(fmt::format("is stuck: no progress for {} {}; heartbeat.stuck_s is {}",
                                   seconds(node.still_ms), work, settings_.stuck_s),
                       true);
    }
    if (has_beaten || node.silent_ms < suspect_intervals * settings_.interval_ms) {
        return std::nullopt;
    }
    const char state = state_of(node.process.pid);
    if (state == 't') {  // A debugger has stopped it.
        node.silent_ms = 0;
        return std::nullopt;
    }
    if (node.silent_ms >= settings_.silence_ms()) {
        return finding(
            fmt::format("does not answer: last heard {} ago {}{}; the limit is {} "
                        "(heartbeat.misses {} of {} ms)",
                        seconds(node.silent_ms), work, state_text(state),
                        seconds(settings_.silence_ms()), settings_.misses, settings_.interval_ms),
            true, state == 'T');
    }
    if (std::exchange(node.is_suspect, true)) {
        return std::nullopt;
    }
    return finding(
        fmt::format(
            "has not answered for {} {}{}; it is ended after {}{}", seconds(node.silent_ms), work,
            state_text(state), seconds(settings_.silence_ms()),
            state == 'T' ? fmt::format("; kill -CONT {} continues it", node.process.pid) : ""),
        false, state == 'T');
}

}  // namespace pxpl5::host
