#include "host/machine/launcher.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <numeric>
#include <system_error>
#include <utility>

#include "host/base/kernel/program_folder.hpp"
#include "host/machine/computers/join/key.hpp"
#include "host/machine/descriptors.hpp"
#include "ringbus/process/process.hpp"
#include "ringbus/wire.hpp"

namespace pxpl5::host {

namespace {

namespace schema = bus::schema;
using schema::Role;

constexpr auto failed_code = static_cast<int>(ExitCode::failed);
constexpr int unavailable_code = 69;
constexpr int max_unused = 4096;  // Messages that one call drops.
constexpr int quiet_ms = 50;      // After this time without messages, the host writes its trace.

/// Closes the descriptor in the destructor.
struct Descriptor {
    int number;
    explicit Descriptor(int opened) : number(opened) {}
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    ~Descriptor() { close(number); }
};

/// How the ring of `topology` is protected. Throws RequestError (usage) if it cannot be.
bus::Protection protection_of(const Topology& topology, const MachineOptions& options) {
    if (topology.ring.transport == Transport::ipc) {
        return bus::Protection::files;
    }
    if (options.insecure_tcp) {
        return bus::Protection::plain_tcp;
    }
    if (!bus::has_curve()) {
        throw RequestError(ExitCode::usage,
                           "ring.transport is tcp, but this computer's libzmq has no CURVE, so any "
                           "user of this computer could take part. Use ring.transport=ipc, install "
                           "a libzmq with libsodium, or pass --insecure-tcp.");
    }
    return bus::Protection::curve;
}

/// The plan, with tcp for other computers. Raises the limit of descriptors, for sockets.
Topology prepared(const Topology& topology) {
    Topology plan = topology;
    if (plan.cluster.is_used()) {
        plan.ring.transport = Transport::tcp;
    }
    provide_limits(roster_of(plan).size(), plan.ring.transport == Transport::tcp);
    return plan;
}

}  // namespace

HeldSignals::HeldSignals() {
    pthread_sigmask(SIG_BLOCK, nullptr, &before_);
    sigdelset(&before_, SIGCHLD);  // The program's parent may have blocked it.
    hold();
}
HeldSignals::~HeldSignals() {
    release();
}
void HeldSignals::hold() {
    sigset_t signals;
    sigemptyset(&signals);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
        sigaddset(&signals, signal);
    }
    pthread_sigmask(SIG_BLOCK, &signals, nullptr);
}
void HeldSignals::release() {
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
}

Launcher::Launcher(const Topology& topology, const MachineOptions& options,
                   std::shared_ptr<Processes> kept)
    : topology_(prepared(topology)),
      options_(options),
      credentials_(kept ? kept->credentials()
                        : machine_key(topology.cluster, protection_of(topology_, options))),
      folder_(make_run_folder(options.run_base, topology_, options.keep_runs)),
      link_({bus::host_id, Role::host}, host_address(topology_, sockets_), credentials_),
      owned_(kept ? std::move(kept)
                  : std::make_shared<Processes>(topology_, credentials_,
                                                Identity{bus::build_id(), bus::schema_hash()},
                                                folder_)),
      processes_(*owned_),
      roster_(roster_of(topology)),
      heartbeat_(topology.heartbeat) {
    options_.binaries = options.binaries.empty() ? program_folder() : options.binaries;
    roster_[0].endpoint = link_.endpoint();
    roster_[0].pid = getpid();
    if (processes_.has_others()) {
        processes_.begin(folder_);
        roster_[0].near_endpoint = near_address(sockets_.path(), "host");
        link_.listen_near(roster_[0].near_endpoint);
        processes_.others().on_pulse(
            [this](const std::string& name, const bus::PulseNumbers& pulse) {
                heartbeat_.take(name, pulse);
            });
    }
    prepare_link();
    start_recording();
    signals_.release();  // The supervisor takes over.
}

void Launcher::prepare_link() {
    bus::RingParameters ring;
    ring.channels = static_cast<std::uint32_t>(topology_.ring.channels);
    ring.bytes_per_s = topology_.ring.channel_bytes_per_s();
    ring.hop_ns = static_cast<std::uint32_t>(topology_.ring.hop_ns);
    std::vector<bus::NodeId> order(roster_.size());
    std::iota(order.begin(), order.end(), bus::host_id);
    link_.set_model(bus::ChannelModel(ring, order));
    io_.host_endpoint =
        link_.listen_apart(Role::io, bind_address(topology_.ring.transport, sockets_, "host-io"));
    link_.on_refusal([this](const bus::Refusal& refusal) { take_refusal(refusal); });
}

Launcher::~Launcher() {
    end_computers();
    signals_.hold();  // The supervisor ends before the sockets are removed.
}

void Launcher::launch() {
    if (processes_.has_others()) {
        gather_computers();
    }
    Roster nodes(roster_.begin() + 1, roster_.end());
    try {
        for (RosterEntry& node : nodes) {
            spawn(node, settings_of(topology_, node.role), {});
        }
    } catch (const MachineError& error) {
        fail(error.code, error.what());
    }
    nodes = bring_up(std::move(nodes));
    std::copy(nodes.begin(), nodes.end(), roster_.begin() + 1);
    launched_ = true;
}

int Launcher::prepare_pulse(const std::string& name) {
    try {
        return heartbeat_.is_on() ? heartbeat_.prepare(name) : -1;
    } catch (const std::system_error& error) {
        throw MachineError(ExitCode::unavailable,
                           fmt::format("{} cannot start: {}", name, error.what()));
    }
}

void Launcher::spawn(RosterEntry& node, const RoleSettings& settings,
                     std::vector<std::string> arguments) {
    const std::string name = node.name();
    bus::ProcessFlags flags = flags_of(node);
    const int cell = prepare_pulse(name);
    if (cell >= 0) {
        flags.pulse_fd = first_inherited_fd + 1;
        flags.pulse_ms = heartbeat_.interval_ms();
    }
    const std::vector<std::string> common = bus::to_arguments(flags);
    arguments.insert(arguments.begin(), common.begin(), common.end());
    const auto& cores = settings.cpu;
    const int core =
        cores.empty() ? -1 : cores[static_cast<std::size_t>(node.index) % cores.size()];
    std::vector<std::string> env = settings.env;
    if (topology_.vector_target != VectorTarget::best) {
        env.push_back(fmt::format("PXPL5_TARGET={}", enum_name(topology_.vector_target)));
    }
    link_.expect(node.id, node.role);
    const Descriptor credentials{bus::credentials_pipe(credentials_)};
    ProcessCommand command{
        name, options_.binaries / node.binary(), std::move(arguments), std::move(env),
        core, folder_ / (name + ".log")};
    command.new_log = node.role == Role::io;
    command.inherited = {credentials.number};
    if (cell >= 0) {
        command.inherited.push_back(cell);
    }
    try {
        node.pid =
            processes_.spawn(node.computer, command, cell >= 0 ? heartbeat_.interval_ms() : 0);
    } catch (...) {
        heartbeat_.forget(name);  // No process will beat in the cell.
        throw;
    }
    if (cell >= 0) {
        heartbeat_.watch({name, node.pid, node.role == Role::io}, now_ms());
    }
}

Roster Launcher::bring_up(Roster nodes) {
    Handshake handshake(std::move(nodes), {bus::build_id(), bus::schema_hash()});
    await("said Hello", handshake, [&handshake] { return handshake.without_hello(); });
    Roster ring = {roster_[0]};
    ring.insert(ring.end(), handshake.nodes().begin(), handshake.nodes().end());
    const bus::Payload told = topology_message(ring, topology_);
    for (const RosterEntry& node : handshake.nodes()) {
        try {
            const bool is_near = node.place == 0 && !node.near_endpoint.empty();
            link_.add_peer(node.id, node.role, is_near ? node.near_endpoint : node.endpoint);
        } catch (const std::invalid_argument& error) {
            blame(node.id, unavailable_code, fmt::format("{}: {}", node.name(), error.what()));
        }
        link_.send(node.id, told);
    }
    await("connected", handshake, [&handshake] { return handshake.unconnected(); });
    const bus::Payload go = bus::pack(schema::GoT{});
    for (const RosterEntry& node : handshake.nodes()) {
        link_.send(node.id, go);
    }
    return handshake.nodes();
}

int Launcher::wait_ms(std::int64_t most_ms) const {
    if (link_.has_more()) {
        return 0;
    }
    const int due_ms = heartbeat_.due_ms(now_ms());
    return most_ms < 0  ? due_ms
           : due_ms < 0 ? static_cast<int>(most_ms)
                        : static_cast<int>(std::min<std::int64_t>(most_ms, due_ms));
}

void Launcher::await(const std::string& what, Handshake& handshake, const Missing& missing) {
    const std::int64_t deadline_ms = now_ms() + std::int64_t{1000} * options_.start_timeout_s;
    for (;;) {
        while (const auto message = take_from_link()) {
            take_control(*message, handshake);
        }
        const std::vector<std::string> names = missing();
        if (names.empty()) {
            return;
        }
        check_health();
        const std::int64_t left_ms = deadline_ms - now_ms();
        if (left_ms <= 0) {
            const std::string text =
                fmt::format("{} {} not {} within {} s", fmt::join(names, ", "),
                            names.size() == 1 ? "has" : "have", what, options_.start_timeout_s);
            if (io_.used && names.front() == io_.used->name()) {
                kill_io();  // The machine works without it.
                throw RequestError(
                    ExitCode::unavailable,
                    work_ + ": " + text + "; the computer may be busy: repeat the command");
            }
            fail(timeout_code, text, names.front());
        }
        wait_for_event(wait_ms(left_ms));
    }
}

void Launcher::take_control(const bus::Message& message, Handshake& handshake) {
    try {
        if (const auto* hello = message.as<schema::Hello>()) {
            handshake.hello(message.source(), *hello);
        } else if (message.kind() == schema::Body::Connected) {
            handshake.connected(message.source());
        } else {
            keep(message);
        }
    } catch (const MachineError& error) {
        blame(message.source(), error.code, error.what());
    }
}

void Launcher::keep(const bus::Message& message) {
    backlog_.bytes += message.bytes().size();
    if (backlog_.messages.size() == max_backlog_messages || backlog_.bytes > max_backlog_bytes) {
        backlog_.bytes -= message.bytes().size();
        blame(message.source(), failed_code,
              fmt::format("{} of {} bytes came from {} although {} messages of {} bytes wait "
                          "already; at most {} of {} bytes may",
                          bus::kind_name(message.kind()), message.bytes().size(),
                          name_of(message.source()), backlog_.messages.size(), backlog_.bytes,
                          max_backlog_messages, max_backlog_bytes));
        return;  // Of an io process that is not in use: it has ended.
    }
    backlog_.messages.push_back(message);
}

std::optional<bus::Message> Launcher::take_from_link() {
    if (io_.early_hello && !io_.prepared) {  // The process is in use now.
        return std::exchange(io_.early_hello, std::nullopt);
    }
    for (int unused = 0; unused < max_unused; ++unused) {
        std::optional<bus::Message> message;
        try {
            message = link_.receive();
        } catch (const bus::BadMessage& bad) {
            blame(bad.source, failed_code, bad.what());
            continue;
        } catch (const bus::WireFault& bad) {  // A gap, so no message can be trusted now.
            blame(bad.source, failed_code, bad.what());
            continue;
        } catch (const std::runtime_error& error) {
            fail(failed_code, error.what());
        }
        const bool is_for_now = message && !is_not_for_now(*message);
        if (is_for_now) {
            note(*message);
        }
        if (io_.offense) {
            if (is_for_now) {
                keep(*message);
            }
            const bus::Refusal offense = *std::exchange(io_.offense, std::nullopt);
            blame(offense.source, failed_code, offense.text);
        } else if (is_for_now || !message) {
            return message;
        }
    }
    link_.come_again();
    return std::nullopt;
}

std::optional<bus::Message> Launcher::receive() {
    if (over_) {
        throw *over_;
    }
    if (backlog_.messages.empty()) {
        std::optional<bus::Message> message = take_from_link();
        if (message) {
            heartbeat_.note_answer();
        }
        return message;
    }
    heartbeat_.note_answer();
    bus::Message message = std::move(backlog_.messages.front());
    backlog_.messages.pop_front();
    backlog_.bytes -= message.bytes().size();
    return message;
}

void Launcher::send(bus::NodeId to, bus::Payload payload) {
    if (over_) {
        throw *over_;
    }
    link_.send(to, std::move(payload));
}

void Launcher::wait() {
    heartbeat_.note_wait();
    if (watcher_.fd >= 0) {
        flush_trace();
        processes_.own().wait_input(processes_.poll_fd(link_.poll_fd()), watcher_.fd,
                                    processes_.wait_ms(wait_ms(-1)));
        processes_.pump(now_ms());
        return;
    }
    if (!recorder_ || !recorder_->has_unwritten()) {
        wait_for_event(wait_ms(-1));
        return;
    }
    const std::int64_t start_ms = now_ms();
    wait_for_event(link_.has_more() ? 0 : quiet_ms);
    if (now_ms() - start_ms >= quiet_ms) {
        flush_trace();
    }
}

void Launcher::wait_readable(int fd) {
    if (over_) {
        throw *over_;
    }
    for (bool readable = false; !readable;) {
        while (const auto message = take_from_link()) {
            keep(*message);
        }
        flush_trace();
        readable = processes_.own().wait_input(processes_.poll_fd(link_.poll_fd()), fd,
                                               processes_.wait_ms(wait_ms(-1)));
        processes_.pump(now_ms());
        check_health();
    }
}

std::string Launcher::name_of(bus::NodeId id) const {
    const auto entry = std::find_if(roster_.begin(), roster_.end(),
                                    [id](const RosterEntry& e) { return e.id == id; });
    const bool is_io = io_.used && io_.used->id == id;
    return entry != roster_.end() ? entry->name()
           : is_io                ? io_.used->name()
                                  : fmt::format("node-{}", id);
}

}  // namespace pxpl5::host
