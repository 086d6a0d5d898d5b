#include "ringbus/process/process.hpp"

#include <doctest/doctest.h>
#include <sched.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <filesystem>

#include "ringbus/trace/trace_file.hpp"
#include "ringbus/zmq/zmq_link.hpp"
#include "tests/ringbus/examples/examples.hpp"
#include "tests/ringbus/ipc_address.hpp"
#include "tests/ringbus/scratch_folder.hpp"
#include "tests/ringbus/wire_bytes.hpp"

using namespace pxpl5;
using namespace pxpl5::bus;
using pxpl5::bus::schema::Role;
using pxpl5::test::contains;
using pxpl5::test::ipc_address;

namespace {

constexpr int patience_ms = 30000;

std::vector<char*> pointers(std::vector<std::string>& words) {
    std::vector<char*> argv;
    for (std::string& word : words) {
        argv.push_back(word.data());
    }
    argv.push_back(nullptr);
    return argv;
}

/// Credentials of a child, as a pipe that the child inherits as credentials_descriptor.
class Inherited {
  public:
    explicit Inherited(const Credentials& credentials) : pipe_(credentials_pipe(credentials)) {
        posix_spawn_file_actions_init(&actions_);
        posix_spawn_file_actions_adddup2(&actions_, pipe_, credentials_descriptor);
    }
    ~Inherited() {
        posix_spawn_file_actions_destroy(&actions_);
        close(pipe_);
    }
    Inherited(const Inherited&) = delete;
    Inherited& operator=(const Inherited&) = delete;
    const posix_spawn_file_actions_t* actions() const { return &actions_; }

  private:
    int pipe_;
    posix_spawn_file_actions_t actions_{};
};

Credentials test_credentials() {
    return make_credentials(Protection::files);
}

/// Starts the echo node. wait_for() returns its exit code.
pid_t start(std::vector<std::string> arguments,
            const Credentials& credentials = test_credentials()) {
    arguments.insert(arguments.begin(), PXPL5_ECHO_NODE);
    const Inherited inherited(credentials);
    pid_t pid = 0;
    REQUIRE(posix_spawn(&pid, PXPL5_ECHO_NODE, inherited.actions(), nullptr,
                        pointers(arguments).data(), environ) == 0);
    return pid;
}

/// Flags of node 1, a child of this process.
ProcessFlags flags_of(const std::string& host, const std::string& bind) {
    ProcessFlags flags{host, bind, 1, 4, getpid()};
    flags.credentials_fd = credentials_descriptor;
    return flags;
}

/// The exit code, or 128 and the signal.
int wait_for(pid_t pid) {
    int status = 0;
    while (waitpid(pid, &status, 0) < 0) {
        REQUIRE(errno == EINTR);
    }
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

Message next(ZmqLink& link) {
    while (true) {
        if (auto message = link.receive()) {
            return *message;
        }
        REQUIRE(link.wait(patience_ms));
    }
}

Payload order(std::uint16_t number) {
    schema::RemoveSurfaceT body;
    body.surface = number;
    return pack(body);
}

/// A message of a GP to a GP.
Payload begin_frame(std::uint16_t number) {
    schema::BeginFrameT begin;
    begin.draw = std::make_unique<schema::DrawFrameT>(test::example_draw());
    begin.draw->frame = number;
    begin.assignment = {0, 0, 0, 0, 0, 0};
    return pack(begin);
}

/// The host's side of an echo node's handshake. This test is also node 2.
struct EchoMachine {
    Credentials credentials = test_credentials();
    ZmqLink host{{host_id, Role::host}, ipc_address("host"), credentials};
    ZmqLink other{{2, Role::gp}, ipc_address("other"), credentials};
    pid_t pid = 0;
    std::string endpoint;

    explicit EchoMachine(Recording record = Recording::off, const std::string& trace_file = "") {
        ProcessFlags flags = flags_of(host.endpoint(), ipc_address("echo"));
        flags.record = record;
        flags.trace_file = trace_file;
        host.expect(1, Role::gp);
        pid = start(to_arguments(flags), credentials);
        const Message message = next(host);
        const auto* hello = message.as<schema::Hello>();
        REQUIRE(hello != nullptr);
        CHECK(message.source() == 1);
        CHECK(hello->role() == schema::Role::gp);
        CHECK(hello->index() == 4);
        CHECK(hello->pid() == static_cast<std::uint32_t>(pid));
        CHECK(refuse_hello(*hello).empty());
        endpoint = hello->endpoint()->str();
    }

    void send_topology(std::uint64_t gp_memory_bytes = 0) {
        schema::TopologyT topology;
        topology.gp_memory_bytes = gp_memory_bytes;
        const std::string endpoints[] = {host.endpoint(), endpoint, other.endpoint()};
        for (std::uint16_t id = 0; id < 3; ++id) {
            topology.nodes.push_back(std::make_unique<schema::NodeInfoT>());
            topology.nodes.back()->id = id;
            topology.nodes.back()->role = id == host_id ? Role::host : Role::gp;
            topology.nodes.back()->endpoint = endpoints[id];
        }
        topology.ring_bytes_per_s = 1'000'000'000;
        topology.ring_hop_ns = 7;
        host.add_peer(1, Role::gp, endpoint);
        host.send(1, pack(topology));
    }

    /// Sends Topology and expects Connected.
    void connect() {
        send_topology();
        CHECK(next(host).kind() == Body::Connected);
    }

    void check_answer(std::uint16_t number) {
        const Message message = next(host);
        REQUIRE(message.kind() == Body::SurfaceBuilt);
        CHECK(message.as<schema::SurfaceBuilt>()->surface() == number);
        CHECK(message.as<schema::SurfaceBuilt>()->revision() == 3);
    }
};

}  // namespace

TEST_SUITE("ringbus/process") {
    TEST_CASE("a node says Hello, connects, works from Go on, and ends at Shutdown") {
        EchoMachine machine;
        machine.connect();
        machine.host.send(1, pack(schema::GoT{}));
        machine.host.send(1, order(3));
        machine.check_answer(3);
        machine.host.send(1, pack(schema::ShutdownT{}));
        CHECK(wait_for(machine.pid) == 0);
    }

    TEST_CASE("messages of peers before Go are kept in order") {
        EchoMachine machine;
        machine.other.add_peer(1, Role::gp, machine.endpoint);
        machine.connect();
        for (std::uint16_t i = 10; i < 40; ++i) {
            machine.other.send(1, begin_frame(i));
        }
        machine.host.send(1, pack(schema::GoT{}));
        for (std::uint16_t i = 10; i < 40; ++i) {
            machine.check_answer(i);
        }
        machine.host.send(1, pack(schema::ShutdownT{}));
        CHECK(wait_for(machine.pid) == 0);
    }

    TEST_CASE("the topology's ring times the messages of its nodes") {
        EchoMachine machine;
        machine.connect();
        machine.host.send(1, pack(schema::GoT{}));
        machine.host.send(1, order(3));
        const Message message = next(machine.host);
        const schema::Header& header = message.header();
        // Two hops from node 1 over node 2 to the host, and a nanosecond per byte.
        const std::uint64_t bytes = 8 + (message.bytes().size() + 3) / 4 * 4;
        CHECK(header.arrival_ns() - header.departure_ns() == 2 * 7 + bytes);
        machine.host.send(1, pack(schema::ShutdownT{}));
        CHECK(wait_for(machine.pid) == 0);
    }

    TEST_CASE("no thread of a node interrupts a working node") {
        EchoMachine machine;
        machine.connect();
        int threads = 0;
        for (const auto& task : std::filesystem::directory_iterator(
                 "/proc/" + std::to_string(machine.pid) + "/task")) {
            CHECK(sched_getscheduler(std::stoi(task.path().filename())) == SCHED_BATCH);
            ++threads;
        }
        CHECK(threads >= 2);  // Its own, and ZeroMQ's.
        machine.host.send(1, pack(schema::ShutdownT{}));
        CHECK(wait_for(machine.pid) == 0);
    }

    TEST_CASE("Shutdown before Go ends a node too") {
        EchoMachine machine;
        machine.host.add_peer(1, Role::gp, machine.endpoint);
        machine.host.send(1, pack(schema::ShutdownT{}));
        CHECK(wait_for(machine.pid) == 0);
    }

    TEST_CASE("a bad message during the handshake is reported to the host") {
        EchoMachine machine;
        machine.host.add_peer(1, Role::gp, machine.endpoint);
        machine.host.send(1, pack(schema::TopologyT{}));
        const Message message = next(machine.host);
        REQUIRE(message.kind() == Body::Fault);
        CHECK(contains(message.as<schema::Fault>()->reason()->str(), "number of nodes is 0"));
        machine.host.send(1, pack(schema::ShutdownT{}));
        CHECK(wait_for(machine.pid) == 0);
    }

    TEST_CASE("a node that has no memory for its Topology ends, and does not connect") {
        EchoMachine machine;
        machine.send_topology(1);
        machine.host.send(1, pack(schema::ShutdownT{}));  // Ends a node that works on.
        CHECK(wait_for(machine.pid) == 70);
        CHECK(!machine.host.receive().has_value());
    }

    TEST_CASE("an internal error ends the node with code 70") {
        EchoMachine machine;
        machine.connect();
        machine.host.send(1, pack(schema::GoT{}));
        machine.host.send(1, order(0xffff));
        CHECK(wait_for(machine.pid) == 70);
    }

    TEST_CASE("a node that ends by an internal error writes its flight recorder") {
        const pxpl5::test::ScratchFolder folder;
        const std::string path = folder / "gp-4.mcap";
        EchoMachine machine(Recording::flight, path);
        machine.connect();
        machine.host.send(1, pack(schema::GoT{}));
        machine.host.send(1, order(0xffff));
        CHECK(wait_for(machine.pid) == 70);
        const trace::TraceFile file(path);
        CHECK(file.cut() == "");
        CHECK(file.info().node_name() == "gp-4");
        REQUIRE(file.entries().size() == 3);
        CHECK(file.entries()[0].kind() == Body::Topology);
        CHECK(file.load(file.entries()[2]).as<schema::RemoveSurface>()->surface() == 0xffff);
    }

    TEST_CASE("a trace that cannot be created ends the node before it joins, with the reason") {
        const pxpl5::test::ScratchFolder folder;
        EchoMachine machine(Recording::full, folder / "no/such/folder.mcap");
        CHECK(wait_for(machine.pid) == 70);
    }

    TEST_CASE("a node that is not its parent's child ends with code 69") {
        ProcessFlags flags = flags_of(ipc_address("absent-host"), ipc_address("orphan"));
        flags.parent_pid = getpid() + 1;
        CHECK(wait_for(start(to_arguments(flags))) == 69);
    }

    TEST_CASE("a bad command line ends with code 64") {
        CHECK(wait_for(start({"--index", "x"})) == 64);
        CHECK(wait_for(start({"--host-endpoint", "ipc:///h", "--node-id", "1", "--bind",
                              "tcp://0.0.0.0:*", "--credentials-fd", "3"})) == 64);
        CHECK(wait_for(start({"--version"})) == 0);
    }

    TEST_CASE("Ctrl-C is left to the launcher") {
        EchoMachine machine;
        kill(machine.pid, SIGINT);
        machine.connect();
        machine.host.send(1, pack(schema::ShutdownT{}));
        CHECK(wait_for(machine.pid) == 0);
    }

    TEST_CASE("a launcher that is killed takes its nodes with it") {
        const Credentials credentials = test_credentials();
        ZmqLink host({host_id, Role::host}, ipc_address("doomed"), credentials);
        host.expect(1, Role::gp);
        int alive[2];
        REQUIRE(pipe(alive) == 0);
        ProcessFlags flags = flags_of(host.endpoint(), ipc_address("taken"));
        flags.parent_pid = 0;
        std::vector<std::string> words = to_arguments(flags);
        const Inherited inherited(credentials);
        words.insert(words.begin(), PXPL5_ECHO_NODE);
        const std::vector<char*> argv = pointers(words);
        const pid_t launcher = fork();
        REQUIRE(launcher >= 0);
        if (launcher == 0) {
            pid_t child = 0;
            posix_spawn(&child, PXPL5_ECHO_NODE, inherited.actions(), nullptr, argv.data(),
                        environ);
            pause();
            _exit(1);
        }
        close(alive[1]);
        CHECK(next(host).kind() == Body::Hello);  // The node holds the pipe's other end.
        kill(launcher, SIGKILL);
        CHECK(wait_for(launcher) == 128 + SIGKILL);
        char byte = 0;
        CHECK(read(alive[0], &byte, 1) == 0);  // Returns when no process has it open.
        close(alive[0]);
    }

    TEST_CASE("flags survive the command line") {
        ProcessFlags flags{"ipc://h",     "ipc://b", 7, 3,   4242, Recording::full,
                           "t/gp-3.mcap", 1234,      4, 500, 3};
        flags.near_bind = "ipc://near";
        flags.compress = true;
        std::vector<std::string> words = to_arguments(flags);
        words.insert(words.begin(), "program");
        words.emplace_back("--memory-mib");  // For the program's own main.
        words.emplace_back("5");
        std::vector<char*> argv;
        for (std::string& word : words) {
            argv.push_back(word.data());
        }
        const ProcessFlags back = parse_flags(static_cast<int>(argv.size()), argv.data());
        CHECK(back.host_endpoint == flags.host_endpoint);
        CHECK(back.bind == flags.bind);
        CHECK(back.node_id == 7);
        CHECK(back.index == 3);
        CHECK(back.parent_pid == 4242);
        CHECK(back.record == Recording::full);
        CHECK(back.trace_file == "t/gp-3.mcap");
        CHECK(back.flight_kib == 1234);
        CHECK(back.pulse_fd == 4);
        CHECK(back.pulse_ms == 500);
        CHECK(back.credentials_fd == 3);
        CHECK(back.near_bind == "ipc://near");
        CHECK(back.compress);
    }

    TEST_CASE("missing and malformed flags are named") {
        const auto error = [](std::vector<std::string> words) {
            words.insert(words.begin(), "program");
            std::vector<char*> argv;
            for (std::string& word : words) {
                argv.push_back(word.data());
            }
            try {
                parse_flags(static_cast<int>(argv.size()), argv.data());
            } catch (const std::invalid_argument& bad) {
                return std::string(bad.what());
            }
            return std::string();
        };
        CHECK(contains(error({}), "--host-endpoint"));
        CHECK(contains(error({"--node-id"}), "--node-id needs a value"));
        CHECK(contains(error({"--node-id", "0"}), "--node-id is '0'"));
        CHECK(contains(error({"--index", "x"}), "--index is 'x'"));
        CHECK(contains(error({"--record", "some"}), "--record is 'some', expected off, flight"));
        CHECK(contains(error({"--host-endpoint", "h", "--bind", "b", "--node-id", "1",
                              "--credentials-fd", "3", "--record", "full"}),
                       "--record needs --trace-file"));
        CHECK(contains(error({"--host-endpoint", "h", "--bind", "b", "--node-id", "1"}),
                       "--credentials-fd are needed"));
    }

    TEST_CASE("a child of another build or schema is refused with both values") {
        const auto answer = [](const std::string& build, std::uint64_t hash) {
            schema::HelloT hello;
            hello.endpoint = "ipc://x";
            hello.build = build;
            hello.schema_hash = hash;
            const Payload payload = pack(hello);
            return refuse_hello(*schema::GetMessage(payload.bytes().data())->body_as_Hello());
        };
        CHECK(answer(build_id(), schema_hash()).empty());
        CHECK(contains(answer("pxpl5 0.0.9", schema_hash()), "pxpl5 0.0.9"));
        CHECK(contains(answer(build_id(), 1), "0000000000000001"));
    }
}
