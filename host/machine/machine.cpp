#include "host/machine/machine.hpp"

#include <utility>

#include "host/machine/launcher.hpp"

namespace pxpl5::host {

namespace {

constexpr int messages_per_check = 64;  // Messages between two checks for deaths and signals.

}  // namespace

struct Machine::Parts {
    Launcher launcher;
    std::vector<bus::NodeId> gps, renderers;
};

Machine::Machine(const Topology& topology, const MachineOptions& options)
    : parts_(new Parts{Launcher(topology, options), {}, {}}) {
    parts_->launcher.launch();
    parts_->gps = ids_of(parts_->launcher.roster(), bus::schema::Role::gp);
    parts_->renderers = ids_of(parts_->launcher.roster(), bus::schema::Role::renderer);
}

Machine::~Machine() = default;

const std::vector<bus::NodeId>& Machine::gp_ids() const {
    return parts_->gps;
}
const std::vector<bus::NodeId>& Machine::renderer_ids() const {
    return parts_->renderers;
}

std::vector<MachineNode> Machine::nodes() const {
    return nodes_of(parts_->launcher.roster());
}
bus::Traffic Machine::traffic() const {
    return parts_->launcher.traffic();
}
void Machine::kill(bus::NodeId id) {
    parts_->launcher.kill(id);
}

void Machine::send(bus::NodeId to, bus::Payload payload) {
    parts_->launcher.send(to, std::move(payload));
}

void Machine::pump(const std::function<void(const bus::Message&)>& take,
                   const std::function<bool()>& done) {
    parts_->launcher.check_health();
    for (int count = 1; !done(); ++count) {
        if (const auto message = parts_->launcher.receive()) {
            take(*message);
            if (count % messages_per_check != 0 && !parts_->launcher.can_be_cancelled()) {
                continue;
            }
        } else if (done()) {  // Called again: receive() may have taken credit.
            return;
        } else {
            parts_->launcher.wait();
        }
        parts_->launcher.check_health();
    }
}

void Machine::wait_readable(int fd) {
    parts_->launcher.wait_readable(fd);
}
void Machine::prepare_io() {
    parts_->launcher.prepare_io();
}
bus::NodeId Machine::start_io(ExitCode on_death) {
    return parts_->launcher.start_io(on_death);
}
void Machine::release_io() {
    parts_->launcher.release_io();
}
flatbuffers::Allocator* Machine::body_allocator() {
    return parts_->launcher.body_allocator();
}
bool Machine::takes_more(bus::NodeId to) const {
    return parts_->launcher.takes_more(to);
}
void Machine::allow_cancel(bool allowed) {
    parts_->launcher.allow_cancel(allowed);
}
void Machine::watch(int fd, std::function<bool()> give_up) {
    parts_->launcher.watch(fd, std::move(give_up));
}
bool Machine::is_recording() const {
    return parts_->launcher.is_recording();
}
SavedTraces Machine::save_traces() {
    return parts_->launcher.save_traces();
}
void Machine::shutdown() {
    parts_->launcher.shutdown();
}

const std::filesystem::path& Machine::run_folder() const {
    return parts_->launcher.folder();
}
std::string Machine::node_name(bus::NodeId id) const {
    return parts_->launcher.name_of(id);
}

std::vector<Machine::Process> Machine::processes() const {
    std::vector<Process> processes;
    for (const RosterEntry& node : parts_->launcher.roster()) {
        processes.push_back({node.name(), node.pid});
    }
    return processes;
}

}  // namespace pxpl5::host
