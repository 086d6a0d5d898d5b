#include "host/machine/machine.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <optional>
#include <utility>

#include "host/machine/computers/cluster_settings.hpp"
#include "host/machine/launcher.hpp"
#include "host/machine/processes/kept_signals.hpp"

namespace pxpl5::host {

namespace {

constexpr int messages_per_check = 64;  // Messages between two checks for deaths and signals.

}  // namespace

/// `launcher` is null only after a start that failed before any process ran.
struct Machine::Parts {
    Parts(const Topology& plan, const MachineOptions& given) : topology(plan), options(given) {}

    Topology topology;
    MachineOptions options;
    std::unique_ptr<Launcher> launcher;
    std::shared_ptr<Processes> kept;  ///< The computers of the machine before, for the next.
    MachineError lost{ExitCode::unavailable, "the machine has not started"};
    /// From the begin of a restart until a launcher runs again.
    std::optional<KeptSignals> kept_signals;
    std::vector<bus::NodeId> gps, renderers, frame_buffers;
    bool cancels_on_interrupt = false;
    int watched_fd = -1;
    std::function<bool()> give_up;
    NameOfSurface name_of_surface;
    std::function<void(const std::string&)> tell_suspect, tell_computer;

    Launcher& running() const {
        if (!launcher) {
            throw lost;
        }
        return *launcher;
    }
    void start(const Topology& plan);
    void end_if_interrupted();
};

/// Throws an interruption if a signal came while there was no launcher.
void Machine::Parts::end_if_interrupted() {
    if (launcher || !kept_signals) {
        return;
    }
    if (const std::deque<int> signals = kept_signals->take(); !signals.empty()) {
        throw interruption(signals.front());
    }
}

void Machine::Parts::start(const Topology& plan) {
    launcher = std::make_unique<Launcher>(plan, options, kept);
    kept.reset();  // If the launcher fails, keep_computers() gives them back.
    launcher->launch();
    gps = ids_of(launcher->roster(), bus::schema::Role::gp);
    renderers = ids_of(launcher->roster(), bus::schema::Role::renderer);
    frame_buffers = ids_of(launcher->roster(), bus::schema::Role::frame_buffer);
}

Machine::Machine(const Topology& topology, const MachineOptions& options)
    : parts_(std::make_unique<Parts>(topology, options)) {
    parts_->start(topology);
}

RestartSettings Machine::restart_of(const std::string& node) const {
    const Topology& plan = parts_->topology;
    return node.starts_with("renderer")      ? plan.renderer.restart
           : node.starts_with("framebuffer") ? plan.frame_buffer.restart
                                             : plan.gp.restart;
}

std::vector<std::string> Machine::io_folders() const {
    return parts_->options.io_allow;
}

void Machine::start_again(const NodeChange& change, int pause_ms) {
    Parts& parts = *parts_;
    if (!parts.kept_signals) {
        parts.kept_signals.emplace();
    }
    parts.end_if_interrupted();
    if (parts.launcher) {
        parts.launcher->rest(pause_ms);
    }
    Topology plan = with_nodes(parts.topology, change.gps, change.renderers);
    if (parts.launcher) {
        try {
            parts.launcher->shutdown_nodes();  // They write their traces. Throws after a death.
        } catch (const MachineError& error) {
            if (error.is_interruption) {
                throw;
            }
        }
    }
    if (parts.launcher) {
        parts.kept = parts.launcher->keep_computers();
    }
    parts.launcher.reset();  // Ends all processes of the host's computer.
    parts.options.is_restart = true;
    try {
        parts.start(plan);
    } catch (const MachineError&) {
        parts.end_if_interrupted();
        throw;
    } catch (const std::exception& error) {
        parts.end_if_interrupted();
        parts.lost = {ExitCode::unavailable, error.what()};
        throw parts.lost;
    }
    parts.kept_signals.reset();
    parts.topology = std::move(plan);
    parts.launcher->watch(parts.watched_fd, parts.give_up);
    parts.launcher->cancel_on_interrupt(parts.cancels_on_interrupt);
    parts.launcher->name_surfaces(parts.name_of_surface);
    parts.launcher->tell_suspects(parts.tell_suspect);
    parts.launcher->tell_computers(parts.tell_computer);
}

Machine::~Machine() = default;

std::vector<MachineComputer> Machine::computers() const {
    return parts_->running().computers();
}
void Machine::use_computers(const std::string& name) {
    ClusterSettings& cluster = parts_->topology.cluster;
    if (!cluster.is_used()) {
        throw RequestError(ExitCode::usage, "this machine has no other computers");
    }
    if (!name.empty()) {
        check_names({name}, "computers", "use");
        parts_->running().await_computer(name);
    }
    cluster.placement = Placement::spread;
    const bool is_named = std::ranges::any_of(
        cluster.computers, [&](const ComputerSlots& each) { return each.name == name; });
    if (!name.empty() && !is_named && !cluster.computers.empty()) {
        cluster.computers.push_back({name, 0});
    }
}
bool Machine::release_computer(const std::string& name) {
    check_names({name}, "computers", "release");
    return parts_->running().release_computer(name);
}
std::string Machine::join_line() {
    return parts_->running().join_line();
}
void Machine::tell_computers(std::function<void(const std::string&)> tell) {
    parts_->tell_computer = std::move(tell);
    if (parts_->launcher) {
        parts_->launcher->tell_computers(parts_->tell_computer);
    }
}

const std::vector<bus::NodeId>& Machine::gp_ids() const {
    return parts_->gps;
}
const std::vector<bus::NodeId>& Machine::renderer_ids() const {
    return parts_->renderers;
}

const std::vector<bus::NodeId>& Machine::frame_buffer_ids() const {
    return parts_->frame_buffers;
}

std::vector<MachineNode> Machine::nodes() const {
    return parts_->running().nodes();
}
bus::Traffic Machine::traffic() const {
    return parts_->running().traffic();
}
void Machine::kill(bus::NodeId id) {
    parts_->running().kill(id);
}

void Machine::send(bus::NodeId to, bus::Payload payload) {
    parts_->running().send(to, std::move(payload));
}

void Machine::pump(const std::function<void(const bus::Message&)>& take,
                   const std::function<bool()>& done) {
    parts_->running().begin_wait();
    parts_->running().check_health();
    for (int count = 1; !done(); ++count) {
        if (const auto message = parts_->running().receive()) {
            take(*message);
            if (count % messages_per_check != 0 && !parts_->running().can_be_canceled()) {
                continue;
            }
        } else if (done()) {  // Called again: receive() may have taken credit.
            return;
        } else {
            parts_->running().wait();
        }
        parts_->running().check_health();
    }
}

void Machine::wait_readable(int fd) {
    parts_->running().wait_readable(fd);
}
void Machine::prepare_io() {
    parts_->running().prepare_io();
}
bus::NodeId Machine::start_io(ExitCode on_death) {
    return parts_->running().start_io(on_death);
}
void Machine::release_io() {
    if (parts_->launcher) {  // Destructors call this.
        parts_->launcher->release_io();
    }
}
flatbuffers::Allocator* Machine::body_allocator() {
    return parts_->running().body_allocator();
}
bool Machine::takes_more(bus::NodeId to) const {
    return parts_->running().takes_more(to);
}
void Machine::allow_cancel(bool allowed) {
    if (parts_->launcher) {
        parts_->launcher->allow_cancel(allowed);
    }
}
void Machine::watch(int fd, std::function<bool()> give_up) {
    parts_->watched_fd = fd;
    parts_->give_up = std::move(give_up);
    if (parts_->launcher) {  // The watcher may go after the machine.
        parts_->launcher->watch(fd, parts_->give_up);
    }
}
void Machine::name_work(const std::string& work) {
    parts_->running().name_work(work);
}
void Machine::name_surfaces(std::function<std::string(std::uint32_t)> name_of) {
    parts_->name_of_surface = std::move(name_of);
    if (parts_->launcher) {
        parts_->launcher->name_surfaces(parts_->name_of_surface);
    }
}
void Machine::tell_suspects(std::function<void(const std::string&)> tell) {
    parts_->tell_suspect = std::move(tell);
    if (parts_->launcher) {
        parts_->launcher->tell_suspects(parts_->tell_suspect);
    }
}
int Machine::slabs_per_set() const {
    return parts_->topology.slabs_per_set;
}
bool Machine::is_recording() const {
    return parts_->running().is_recording();
}
void Machine::allow_give_up(bool allowed) {
    if (parts_->launcher) {
        parts_->launcher->allow_give_up(allowed);
    }
}
void Machine::cancel_on_interrupt(bool allowed) {
    parts_->cancels_on_interrupt = allowed;
    if (parts_->launcher) {
        parts_->launcher->cancel_on_interrupt(allowed);
    }
}
SavedTraces Machine::save_traces() {
    return parts_->running().save_traces(save_ms);
}
SavedTraces Machine::save_traces_after_fault() {
    return parts_->running().save_traces(fault_save_ms);
}
void Machine::shutdown() {
    parts_->running().shutdown();
}

const std::filesystem::path& Machine::run_folder() const {
    return parts_->running().folder();
}
std::string Machine::node_name(bus::NodeId id) const {
    return parts_->running().name_of(id);
}

std::vector<Machine::Process> Machine::processes() const {
    std::vector<Process> processes;
    for (const RosterEntry& node : parts_->running().roster()) {
        processes.push_back({node.name(), node.pid});
    }
    return processes;
}

}  // namespace pxpl5::host
