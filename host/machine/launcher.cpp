#include "host/machine/launcher.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <numeric>
#include <utility>

#include "ringbus/process/process.hpp"

namespace pxpl5::host {

namespace {

namespace schema = bus::schema;
using schema::Role;

constexpr int failed_code = 1;
constexpr int unavailable_code = 69;
constexpr int timeout_code = 124;
constexpr int quiet_ms = 50;  // After this time without messages, the host writes its trace.
constexpr std::uint64_t bytes_per_mb = 1'000'000;

std::filesystem::path own_folder() {
    return std::filesystem::read_symlink("/proc/self/exe").parent_path();
}

std::string bind_address(Transport transport, const SocketFolder& sockets,
                         const std::string& name) {
    return transport == Transport::tcp ? "tcp://127.0.0.1:*"
                                       : fmt::format("ipc://{}", (sockets.path() / name).string());
}

}  // namespace

HeldSignals::HeldSignals() {
    pthread_sigmask(SIG_BLOCK, nullptr, &before_);
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

Launcher::Launcher(const Topology& topology, const MachineOptions& options)
    : topology_(topology),
      options_(options),
      folder_(make_run_folder(options.run_base, topology)),
      link_(bus::host_id, bind_address(topology.ring.transport, sockets_, "host")),
      roster_(roster_of(topology)) {
    options_.binaries = options.binaries.empty() ? own_folder() : options.binaries;
    roster_[0].endpoint = link_.endpoint();
    roster_[0].pid = getpid();
    bus::RingParameters ring;
    ring.channels = static_cast<std::uint32_t>(topology.ring.channels);
    ring.bytes_per_s = bytes_per_mb * static_cast<std::uint64_t>(topology.ring.channel_mb_s);
    ring.hop_ns = static_cast<std::uint32_t>(topology.ring.hop_ns);
    std::vector<bus::NodeId> order(roster_.size());
    std::iota(order.begin(), order.end(), bus::host_id);
    link_.set_model(bus::ChannelModel(ring, order));
    start_recording();
    signals_.release();  // The supervisor takes over.
}

Launcher::~Launcher() {
    signals_.hold();  // The supervisor ends before the sockets are removed.
}

void Launcher::launch() {
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

void Launcher::spawn(RosterEntry& node, const RoleSettings& settings,
                     std::vector<std::string> arguments) {
    const std::string name = node.name();
    bus::ProcessFlags flags;
    flags.host_endpoint = link_.endpoint();
    flags.bind = bind_address(topology_.ring.transport, sockets_, name);
    flags.node_id = node.id;
    flags.index = static_cast<std::uint16_t>(node.index);
    flags.parent_pid = getpid();
    if (recorder_ && node.role != Role::io) {
        flags.record = static_cast<Recording>(topology_.record);
        flags.trace_file = trace_path(name).string();
        flags.flight_kib = flight_share_kib();
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
    node.pid = supervisor_.spawn({name, options_.binaries / node.binary(), std::move(arguments),
                                  std::move(env), core, folder_ / (name + ".log")});
}

Roster Launcher::bring_up(Roster nodes) {
    Handshake handshake(std::move(nodes), {bus::build_id(), bus::schema_hash()});
    await("said Hello", handshake, [&handshake] { return handshake.without_hello(); });
    Roster ring = {roster_[0]};
    ring.insert(ring.end(), handshake.nodes().begin(), handshake.nodes().end());
    const bus::Payload told = topology_message(ring, topology_);
    for (const RosterEntry& node : handshake.nodes()) {
        link_.add_peer(node.id, node.endpoint);
        link_.send(node.id, told);
    }
    await("connected", handshake, [&handshake] { return handshake.unconnected(); });
    const bus::Payload go = bus::pack(schema::GoT{});
    for (const RosterEntry& node : handshake.nodes()) {
        link_.send(node.id, go);
    }
    return handshake.nodes();
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
            fail(timeout_code,
                 fmt::format("{} {} not {} within {} s", fmt::join(names, ", "),
                             names.size() == 1 ? "has" : "have", what, options_.start_timeout_s));
        }
        supervisor_.wait(link_.poll_fd(), static_cast<int>(left_ms));
    }
}

void Launcher::take_control(const bus::Message& message, Handshake& handshake) {
    try {
        if (const auto* hello = message.as<schema::Hello>()) {
            handshake.hello(*hello);
        } else if (message.kind() == schema::Body::Connected) {
            handshake.connected(message.source());
        } else {
            keep(message);
        }
    } catch (const MachineError& error) {
        fail(error.code, error.what());
    }
}

void Launcher::keep(const bus::Message& message) {
    backlog_bytes_ += message.bytes().size();
    if (backlog_.size() == max_backlog_messages || backlog_bytes_ > max_backlog_bytes) {
        fail(failed_code,
             fmt::format("{} of {} bytes came from {} although {} messages of {} bytes wait "
                         "already; at most {} of {} bytes may",
                         bus::kind_name(message.kind()), message.bytes().size(),
                         name_of(message.source()), backlog_.size(),
                         backlog_bytes_ - message.bytes().size(), max_backlog_messages,
                         max_backlog_bytes));
    }
    backlog_.push_back(message);
}

/// Whether an earlier io process sent the message, or a prepared one, whose Hello is kept. A
/// prepared process sends no other message on its own.
bool Launcher::is_not_for_now(const bus::Message& message) {
    if (io_.prepared && io_.prepared->id == message.source()) {
        note(message);
        if (message.kind() == schema::Body::Hello) {
            io_.early_hello = message;
        }
        return true;
    }
    return io_.dismissed.count(message.source()) != 0;
}

std::optional<bus::Message> Launcher::take_from_link() {
    try {
        if (io_.early_hello && !io_.prepared) {  // The process is in use now.
            return std::exchange(io_.early_hello, std::nullopt);
        }
        std::optional<bus::Message> message = link_.receive();
        while (message && is_not_for_now(*message)) {
            message = link_.receive();
        }
        if (message) {
            note(*message);
        }
        return message;
    } catch (
        const std::runtime_error& error) {  // BadMessage, or a gap: no message can be trusted now.
        fail(failed_code, error.what());
    }
}

std::optional<bus::Message> Launcher::receive() {
    if (over_) {
        throw *over_;
    }
    if (backlog_.empty()) {
        return take_from_link();
    }
    bus::Message message = std::move(backlog_.front());
    backlog_.pop_front();
    backlog_bytes_ -= message.bytes().size();
    return message;
}

void Launcher::send(bus::NodeId to, bus::Payload payload) {
    if (over_) {
        throw *over_;
    }
    link_.send(to, std::move(payload));
}

void Launcher::wait() {
    if (watched_fd_ >= 0) {
        flush_trace();
        supervisor_.wait_input(link_.poll_fd(), watched_fd_);
        return;
    }
    if (!recorder_ || !recorder_->has_unwritten()) {
        supervisor_.wait(link_.poll_fd(), -1);
        return;
    }
    const std::int64_t start_ms = now_ms();
    supervisor_.wait(link_.poll_fd(), quiet_ms);
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
        readable = supervisor_.wait_input(link_.poll_fd(), fd);
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
