#include "ringbus/process/process.hpp"

#include <fmt/core.h>
#include <sched.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <charconv>
#include <csignal>
#include <cstdio>
#include <deque>
#include <new>
#include <stdexcept>
#include <string_view>

#include "ringbus/node_loop.hpp"
#include "ringbus/trace/recorder.hpp"
#include "ringbus/zmq/zmq_link.hpp"

namespace pxpl5::bus {

namespace {

enum ExitCode : int { done = 0, usage = 64, unavailable = 69, internal = 70 };

constexpr int handshake_quiet_ms = 1000;
constexpr int last_words_ms = 500;  ///< Time for the last messages of a node to the host.

int parse_whole(std::string_view flag, std::string_view text, int low, int high) {
    int value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size() || value < low || value > high) {
        throw std::invalid_argument(
            fmt::format("{} is '{}', expected a whole number in {} .. {}", flag, text, low, high));
    }
    return value;
}

Recording parse_recording(std::string_view flag, std::string_view text) {
    if (const std::optional<Recording> recording = enum_named<Recording>(text)) {
        return *recording;
    }
    throw std::invalid_argument(
        fmt::format("{} is '{}', expected off, flight or full", flag, text));
}

/// Ends the process when its launcher ends, even by a signal.
bool tie_to_parent(int parent_pid) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    return parent_pid == 0 || getppid() == parent_pid;
}

/// Keeps messages from interrupting a node at work. With more threads than cores, the messages of
/// a frame then collect, and wake their receiver once.
void work_without_preemption() {
    if (sched_getscheduler(0) == SCHED_OTHER) {  // Otherwise the launcher has chosen a policy.
        const sched_param none{};
        sched_setscheduler(0, SCHED_BATCH, &none);
    }
}

Payload hello_message(schema::Role role, const ProcessFlags& flags, const ZmqLink& link,
                      const schema::Secret& secret) {
    schema::HelloT hello;
    hello.role = role;
    hello.index = flags.index;
    hello.pid = static_cast<std::uint32_t>(getpid());
    hello.endpoint = link.endpoint();
    hello.near_endpoint = flags.near_bind;
    hello.build = build_id();
    hello.schema_hash = schema_hash();
    hello.secret = std::make_unique<schema::Secret>(secret);
    return pack(hello);
}

/// The number of the computer on which node `id` runs; -1 for an io process, which is not listed.
int computer_of(const schema::Topology& topology, NodeId id) {
    for (const auto* node : *topology.nodes()) {
        if (node->id() == id) {
            return node->computer();
        }
    }
    return -1;
}

/// Takes the addresses of all nodes and the ring's order and parameters from the topology. Sockets
/// are opened by the first message.
void learn_ring(ZmqLink& link, const schema::Topology& topology) {
    std::vector<NodeId> order;
    const int own_computer = computer_of(topology, link.id());
    for (const auto* node : *topology.nodes()) {
        order.push_back(node->id());
        if (node->id() != link.id() && node->id() != host_id) {
            const bool is_near =
                node->computer() == own_computer && node->near_endpoint() != nullptr;
            link.add_peer(node->id(), node->role(),
                          (is_near ? node->near_endpoint() : node->endpoint())->str());
        }
    }
    RingParameters parameters;
    parameters.channels = topology.ring_channels();
    if (topology.ring_bytes_per_s() != 0) {
        parameters.bytes_per_s = topology.ring_bytes_per_s();
        parameters.hop_ns = topology.ring_hop_ns();
    }
    link.set_model(ChannelModel(parameters, order));
}

/// Runs the handshake: Hello, Topology, Connected, Go. Appends messages that precede Go to `early`.
/// Returns false after Shutdown or when the parent has ended. Throws what the node throws at
/// Topology: without it, the node can do no work, and the host learns that the process has ended.
bool join(ZmqLink& ring, Link& link, Node& node, LinkOutbox& out,
          const std::function<bool()>& alive, Pulse& pulse, std::deque<Message>& early) {
    while (true) {
        const std::optional<Message> message = receive_or_report(link, out);
        if (!message) {
            pulse.enter(Phase::waiting);
            if (!link.wait(handshake_quiet_ms) && !alive()) {
                return false;
            }
            continue;
        }
        pulse.enter(Phase::receiving, {message->kind()});
        if (const auto* topology = message->as<schema::Topology>()) {
            learn_ring(ring, *topology);
            node.receive(*message, out);
            link.send(host_id, pack(schema::ConnectedT{}));
        } else if (message->kind() == Body::Go) {
            return true;
        } else if (message->kind() == Body::Shutdown) {
            return false;
        } else {
            early.push_back(*message);
        }
    }
}

/// Drives `node` over `link`, which may be `ring` itself, from Hello to Shutdown.
int drive(ZmqLink& ring, Link& link, Node& node, const std::function<bool()>& alive, Pulse& pulse) {
    LinkOutbox out(link);
    std::deque<Message> early;
    if (!join(ring, link, node, out, alive, pulse, early)) {
        return alive() ? done : unavailable;
    }
    for (const Message& message : early) {
        deliver(node, link.id(), message, out);
    }
    early.clear();
    return run_node(node, link, alive, pulse) ? done : unavailable;
}

trace::Info trace_info(const ProcessFlags& flags, schema::Role role) {
    trace::Info info;
    info.build = build_id();
    info.schema_hash = schema_hash();
    info.node = flags.node_id;
    info.role = role;
    info.index = flags.index;
    info.recording = flags.record;
    return info;
}

void save_at_failure(trace::Recorder& recorder) {
    try {
        recorder.save();
    } catch (const trace::TraceError& error) {
        fmt::print(stderr, "error: {}\n", error.what());  // The caller prints the cause.
    }
}

/// The same, recording. What a flight holds is written if the node ends by an exception.
int drive_recorded(ZmqLink& ring, const ProcessFlags& flags, schema::Role role, Node& node,
                   const std::function<bool()>& alive, Pulse& pulse, const LeaveOut& leave_out) {
    trace::Limits limits;
    limits.share_bytes = static_cast<std::size_t>(flags.flight_kib) * 1024;
    trace::Recorder recorder(flags.trace_file, trace_info(flags, role), limits);
    trace::RecordingLink link(ring, recorder, leave_out);
    try {
        const int code = drive(ring, link, node, alive, pulse);
        recorder.close();
        return code;
    } catch (const std::exception&) {
        save_at_failure(recorder);
        throw;
    }
}

/// Names the first refusals in the node's log. The activity of the node has their number.
void print_refusal(const Refusal& refusal) {
    fmt::print(stderr, "dropped {}; more of this kind are only counted\n", refusal.text);
    std::fflush(stderr);
}

int run(const ProcessFlags& flags, schema::Role role, const NodeFactory& make_node,
        const LeaveOut& leave_out) {
    const auto alive = [&flags] { return flags.parent_pid == 0 || getppid() == flags.parent_pid; };
    std::optional<Pulse> pulse;
    flags.pulse_fd < 0 ? pulse.emplace() : pulse.emplace(flags.pulse_fd, flags.pulse_ms);
    const Credentials credentials = inherit_credentials(flags.credentials_fd);
    ZmqLink link({flags.node_id, role}, flags.bind, credentials);
    if (!flags.near_bind.empty()) {
        link.listen_near(flags.near_bind);
    }
    link.compress_far(flags.compress);
    link.on_refusal(&print_refusal);
    link.add_peer(host_id, schema::Role::host, flags.host_endpoint);
    link.linger(host_id, last_words_ms);
    const std::unique_ptr<Node> node = make_node();
    link.send(host_id, hello_message(role, flags, link, credentials.secret));
    return flags.record == Recording::off
               ? drive(link, link, *node, alive, *pulse)
               : drive_recorded(link, flags, role, *node, alive, *pulse, leave_out);
}

}  // namespace

std::vector<std::string> to_arguments(const ProcessFlags& flags) {
    std::vector<std::string> arguments = {"--host-endpoint",  flags.host_endpoint,
                                          "--bind",           flags.bind,
                                          "--node-id",        std::to_string(flags.node_id),
                                          "--index",          std::to_string(flags.index),
                                          "--parent-pid",     std::to_string(flags.parent_pid),
                                          "--credentials-fd", std::to_string(flags.credentials_fd)};
    if (!flags.near_bind.empty()) {
        arguments.insert(arguments.end(), {"--near-bind", flags.near_bind});
    }
    if (flags.compress) {
        arguments.emplace_back("--compress");
    }
    if (flags.record != Recording::off) {
        arguments.insert(arguments.end(),
                         {"--record", enum_name(flags.record), "--trace-file", flags.trace_file,
                          "--flight-kib", std::to_string(flags.flight_kib)});
    }
    if (flags.pulse_fd >= 0) {
        arguments.insert(arguments.end(), {"--pulse-fd", std::to_string(flags.pulse_fd),
                                           "--pulse-ms", std::to_string(flags.pulse_ms)});
    }
    return arguments;
}

ProcessFlags parse_flags(int argc, char** argv) {
    ProcessFlags flags;
    for (int i = 1; i < argc; ++i) {
        const std::string_view flag = argv[i];
        const auto value = [&]() -> std::string_view {
            if (i + 1 == argc) {
                throw std::invalid_argument(fmt::format("{} needs a value", flag));
            }
            return argv[++i];
        };
        if (flag == "--host-endpoint") {
            flags.host_endpoint = value();
        } else if (flag == "--bind") {
            flags.bind = value();
        } else if (flag == "--near-bind") {
            flags.near_bind = value();
        } else if (flag == "--compress") {
            flags.compress = true;
        } else if (flag == "--node-id") {
            flags.node_id = static_cast<NodeId>(parse_whole(flag, value(), 1, 0xffff));
        } else if (flag == "--index") {
            flags.index = static_cast<std::uint16_t>(parse_whole(flag, value(), 0, 0xffff));
        } else if (flag == "--parent-pid") {
            flags.parent_pid = parse_whole(flag, value(), 0, 1 << 30);
        } else if (flag == "--record") {
            flags.record = parse_recording(flag, value());
        } else if (flag == "--trace-file") {
            flags.trace_file = value();
        } else if (flag == "--flight-kib") {
            flags.flight_kib = parse_whole(flag, value(), 0, 1 << 20);
        } else if (flag == "--pulse-fd") {
            flags.pulse_fd = parse_whole(flag, value(), 3, 1 << 20);
        } else if (flag == "--pulse-ms") {
            flags.pulse_ms = parse_whole(flag, value(), 1, 1 << 20);
        } else if (flag == "--credentials-fd") {
            flags.credentials_fd = parse_whole(flag, value(), 0, 1 << 20);
        }
    }
    if (flags.host_endpoint.empty() || flags.bind.empty() || flags.node_id == 0 ||
        flags.credentials_fd < 0) {
        throw std::invalid_argument(
            "--host-endpoint, --bind, --node-id and --credentials-fd are needed; pxpl5 starts this "
            "program itself");
    }
    if (flags.record != Recording::off && flags.trace_file.empty()) {
        throw std::invalid_argument("--record needs --trace-file: where the recording goes");
    }
    return flags;
}

std::string build_id() {
    return fmt::format("pxpl5 {}, protocol {}", PXPL5_VERSION, protocol_version);
}

std::string refuse_hello(const schema::Hello& hello) {
    if (hello.build()->str() != build_id()) {
        return fmt::format("build is '{}', the host is '{}'", hello.build()->str(), build_id());
    }
    if (hello.schema_hash() != schema_hash()) {
        return fmt::format("message schemas have hash {:016x}, the host's have {:016x}",
                           hello.schema_hash(), schema_hash());
    }
    return {};
}

int run_process(int argc, char** argv, schema::Role role, const NodeFactory& make_node,
                const LeaveOut& leave_out) {
    if (argc == 2 && std::string_view(argv[1]) == "--version") {
        fmt::print("{}\n", build_id());
        return done;
    }
    try {
        const ProcessFlags flags = parse_flags(argc, argv);
        // Ctrl-C reaches the whole terminal; the host decides what it means.
        std::signal(SIGINT, SIG_IGN);
        std::signal(SIGXFSZ, SIG_IGN);  // A trace that grows too large is an error of its writer.
        work_without_preemption();
        return tie_to_parent(flags.parent_pid) ? run(flags, role, make_node, leave_out)
                                               : unavailable;
    } catch (const std::invalid_argument& error) {
        fmt::print(stderr, "error: {}\n", error.what());
        return usage;
    } catch (const std::bad_alloc&) {
        fmt::print(stderr, "error: {}\n", memory_exhausted);
        return internal;
    } catch (const std::exception& error) {
        fmt::print(stderr, "error: {}\n", error.what());
        return internal;
    }
}

}  // namespace pxpl5::bus
