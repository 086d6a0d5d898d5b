#include <doctest/doctest.h>
#include <poll.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "host/error.hpp"
#include "host/machine/machine.hpp"
#include "ringbus/process.hpp"
#include "tests/host/machine/idle_node.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using test::Order;
namespace schema = bus::schema;
namespace fs = std::filesystem;

namespace {

constexpr int limit_ms = 5000;  // For everyone to be gone, after a kill.

std::string text_of(const fs::path& path) {
    std::ostringstream text;
    text << std::ifstream(path).rdbuf();
    return text.str();
}

bool has(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

/// Follows a process that need not be a child, until it has ended.
class Watch {
  public:
    explicit Watch(int pid) : fd_(static_cast<int>(syscall(SYS_pidfd_open, pid, 0))) {}
    Watch(Watch&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
    ~Watch() {
        if (fd_ >= 0) {
            close(fd_);
        }
    }
    bool existed() const { return fd_ >= 0; }
    bool ends_within(int timeout_ms) const {
        pollfd entry{fd_, POLLIN, 0};
        return poll(&entry, 1, timeout_ms) == 1;
    }

  private:
    int fd_;
};

struct Bench {
    Bench() {
        std::string pattern = fs::temp_directory_path() / "pxpl5-test-XXXXXX";
        REQUIRE(mkdtemp(pattern.data()) != nullptr);
        folder = pattern;
        setenv("XDG_RUNTIME_DIR", pattern.c_str(), 1);  // Sockets can be counted here.
        options.binaries = PXPL5_IDLE_NODES;
        options.run_base = folder / "run";
        topology.gp.count = 2;
        topology.renderer.count = 2;
        topology.frame_buffer.count = 1;
    }
    ~Bench() { fs::remove_all(folder); }

    std::size_t socket_folders() const {
        std::size_t count = 0;
        for (const auto& entry : fs::directory_iterator(folder)) {
            count += entry.path().filename().string().starts_with("pxpl5-") ? 1 : 0;
        }
        return count;
    }

    fs::path folder;
    MachineOptions options;
    Topology topology;
};

std::vector<Watch> watch_nodes(const Machine& machine) {
    std::vector<Watch> watches;
    for (const Machine::Process& process : machine.processes()) {
        if (process.name != "host") {
            watches.emplace_back(process.pid);
            CHECK(watches.back().existed());
        }
    }
    return watches;
}

void check_all_ended(const std::vector<Watch>& watches, int timeout_ms = 0) {
    for (const Watch& watch : watches) {
        CHECK(watch.ends_within(timeout_ms));
    }
}

bus::Payload order(Order what) {
    schema::RemoveSurfaceT message;
    message.surface = static_cast<std::uint16_t>(what);
    return bus::pack(message);
}

void ignore(const bus::Message&) {}
bool never() {
    return false;
}

/// The error that pumping on comes to.
MachineError end_of(Machine& machine) {
    try {
        machine.pump(ignore, never);
    } catch (const MachineError& error) {
        return error;
    }
    return {0, "no error"};
}

int pid_of(const Machine& machine, const std::string& name) {
    for (const Machine::Process& process : machine.processes()) {
        if (process.name == name) {
            return process.pid;
        }
    }
    FAIL(name, " is not there");
    return 0;
}

/// Waits until every GP has answered once.
void ask_all(Machine& machine) {
    std::vector<bus::NodeId> answers;
    for (const bus::NodeId id : machine.gp_ids()) {
        machine.send(id, order(Order::answer));
    }
    machine.pump([&](const bus::Message& message) { answers.push_back(message.source()); },
                 [&] { return answers.size() == machine.gp_ids().size(); });
    std::sort(answers.begin(), answers.end());
    CHECK(answers == machine.gp_ids());
}

MachineError start_error(const Bench& bench) {
    try {
        const Machine machine(bench.topology, bench.options);
    } catch (const MachineError& error) {
        return error;
    }
    return {0, "no error"};
}

}  // namespace

TEST_CASE("a machine comes up, answers, and goes down without a trace but its run folder") {
    for (const Transport transport : {Transport::ipc, Transport::tcp}) {
        Bench bench;
        bench.topology.ring.transport = transport;
        std::vector<Watch> nodes;
        fs::path run;
        {
            Machine machine(bench.topology, bench.options);
            run = machine.run_folder();
            CHECK(bench.socket_folders() == 1);
            CHECK(machine.gp_ids() == std::vector<bus::NodeId>{1, 2});
            CHECK(machine.renderer_ids() == std::vector<bus::NodeId>{3, 4});
            CHECK(machine.node_name(4) == "renderer-1");
            nodes = watch_nodes(machine);
            CHECK(nodes.size() == 5);
            ask_all(machine);
            machine.shutdown();
            check_all_ended(nodes);
            CHECK_THROWS_AS(ask_all(machine), MachineError);
        }
        CHECK(bench.socket_folders() == 0);
        for (const char* name : {"gp-0", "gp-1", "renderer-0", "renderer-1", "framebuffer-0"}) {
            CHECK(has(text_of(run / (std::string(name) + ".log")), std::string(name) + ": "));
        }
        const Topology again = load_topology((run / "config.resolved.json").string());
        CHECK(resolved_json(again) == resolved_json(bench.topology));
        CHECK(has(text_of(run / "manifest.json"), "\"schema_hash\""));
    }
}

TEST_CASE("a node that is killed ends the machine, which names it and leaves no process") {
    Bench bench;
    Machine machine(bench.topology, bench.options);
    const std::vector<Watch> nodes = watch_nodes(machine);
    ::kill(pid_of(machine, "gp-1"), SIGKILL);
    const MachineError error = end_of(machine);
    CHECK(error.code == 137);
    CHECK_MESSAGE(has(error.what(), "gp-1 was killed by signal 9 (SIGKILL)"), error.what());
    check_all_ended(nodes);
    CHECK_MESSAGE(end_of(machine).what() == std::string(error.what()), "and it stays so");
    CHECK_THROWS_AS(machine.send(1, order(Order::answer)), MachineError);
    CHECK_THROWS_AS(machine.shutdown(), MachineError);
}

TEST_CASE("a node that gives up ends the machine with its exit code and its last words") {
    Bench bench;
    Machine machine(bench.topology, bench.options);
    const std::vector<Watch> nodes = watch_nodes(machine);
    machine.send(machine.renderer_ids()[1], order(Order::exit_70));
    const MachineError error = end_of(machine);
    CHECK(error.code == 70);
    CHECK_MESSAGE(has(error.what(), "renderer-1 ended with exit code 70: error: as ordered"),
                  error.what());
    check_all_ended(nodes);
}

TEST_CASE("a node that leaves uninvited is an error even with exit code 0") {
    Bench bench;
    Machine machine(bench.topology, bench.options);
    machine.send(machine.gp_ids()[0], order(Order::leave));
    const MachineError error = end_of(machine);
    CHECK(error.code == 69);
    CHECK_MESSAGE(has(error.what(), "gp-0 ended with exit code 0"), error.what());
}

TEST_CASE("a Fault is a message like any other, and the machine goes on") {
    Bench bench;
    Machine machine(bench.topology, bench.options);
    machine.send(machine.gp_ids()[1], order(Order::fault));
    std::string reason;
    machine.pump(
        [&](const bus::Message& message) {
            const auto* fault = message.as<schema::Fault>();
            REQUIRE(fault != nullptr);
            CHECK(fault->node() == machine.gp_ids()[1]);
            reason = fault->reason()->str();
        },
        [&] { return !reason.empty(); });
    CHECK(reason == "as ordered");
    ask_all(machine);
    machine.shutdown();
}

TEST_CASE("a node of another build is refused with both builds") {
    Bench bench;
    bench.topology.frame_buffer.env = {"MISBEHAVE=build"};
    const MachineError error = start_error(bench);
    CHECK(error.code == 69);
    CHECK_MESSAGE(
        has(error.what(), "framebuffer-0 is of build 'another build', the host of build '" +
                              bus::build_id() + "'"),
        error.what());
    CHECK(bench.socket_folders() == 0);
}

TEST_CASE("nodes that do not answer in time are named") {
    Bench bench;
    bench.topology.renderer.env = {"MISBEHAVE=silent"};
    bench.options.start_timeout_s = 1;
    const MachineError error = start_error(bench);
    CHECK(error.code == 124);
    CHECK_MESSAGE(has(error.what(), "renderer-0, renderer-1 have not said Hello within 1 s"),
                  error.what());
}

TEST_CASE("a binary that is missing is named") {
    Bench bench;
    bench.options.binaries = bench.folder;
    const MachineError error = start_error(bench);
    CHECK(error.code == 69);
    CHECK_MESSAGE(has(error.what(), "gp-0 cannot start: " + (bench.folder / "pxpl5-gp").string()),
                  error.what());
}

TEST_CASE("a node that will not end is killed in the end, and named") {
    Bench bench;
    bench.topology.frame_buffer.env = {"MISBEHAVE=deaf"};
    bench.options.drain_ms = 100;
    Machine machine(bench.topology, bench.options);
    const std::vector<Watch> nodes = watch_nodes(machine);
    std::string text;
    try {
        machine.shutdown();
    } catch (const MachineError& error) {
        CHECK(error.code == 137);
        text = error.what();
    }
    CHECK_MESSAGE(has(text, "framebuffer-0 was killed by signal 9 (SIGKILL)"), text);
    check_all_ended(nodes);
}

TEST_CASE("an io process comes and goes; its death is the request's error, not the machine's") {
    Bench bench;
    Machine machine(bench.topology, bench.options);
    for (int round = 0; round < 3; ++round) {
        const bus::NodeId io = machine.start_io();
        CHECK(machine.node_name(io) == "io-" + std::to_string(round));
        bool answered = false;
        machine.send(io, order(Order::answer));
        machine.pump([&](const bus::Message& m) { answered = answered || m.source() == io; },
                     [&] { return answered; });
        machine.release_io();
        ask_all(machine);
    }
    machine.send(machine.start_io(), order(Order::abort));
    std::string text;
    try {
        machine.pump(ignore, never);
    } catch (const RequestError& error) {
        CHECK(error.code == ExitCode::bad_data);
        text = error.what();
    }
    CHECK_MESSAGE(has(text, "io-3 was killed by signal 6 (SIGABRT)"), text);
    ask_all(machine);
    machine.start_io();
    ask_all(machine);
    machine.shutdown();
}

TEST_CASE("what the nodes say while an io process starts is not lost") {
    Bench bench;
    Machine machine(bench.topology, bench.options);
    for (const bus::NodeId id : machine.gp_ids()) {
        machine.send(id, order(Order::answer));
    }
    machine.start_io();
    std::size_t answers = 0;
    machine.pump([&](const bus::Message&) { ++answers; }, [&] { return answers == 2; });
    machine.shutdown();
}

namespace {

/// The idle host as a child process, up and running.
struct HostProcess {
    HostProcess(const Bench& bench, const std::vector<std::string>& settings) {
        int out[2], err[2];
        REQUIRE(pipe(out) == 0);
        REQUIRE(pipe(err) == 0);
        pid = fork();
        if (pid == 0) {
            dup2(out[1], 1);
            dup2(err[1], 2);
            for (const int fd : {out[0], out[1], err[0], err[1]}) {
                close(fd);
            }
            std::vector<std::string> words = {PXPL5_IDLE_HOST, PXPL5_IDLE_NODES,
                                              (bench.folder / "run").string(), "one-of-each"};
            words.insert(words.end(), settings.begin(), settings.end());
            std::vector<char*> arguments;
            for (std::string& word : words) {
                arguments.push_back(word.data());
            }
            arguments.push_back(nullptr);
            execv(arguments[0], arguments.data());
            _exit(127);
        }
        close(out[1]);
        close(err[1]);
        errors = fdopen(err[0], "r");
        FILE* lines = fdopen(out[0], "r");
        char name[64];
        for (int node = 0; std::fscanf(lines, "%d %63s", &node, name) == 2;) {
            nodes.emplace_back(node);
            names.emplace_back(name);
        }
        std::fclose(lines);
    }
    ~HostProcess() { std::fclose(errors); }

    /// Waits for the host's end. Returns its exit code, or 128 + signal.
    int wait() const {
        int status = 0;
        REQUIRE(waitpid(pid, &status, 0) == pid);
        return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    }
    std::string error_text() const {
        std::string text;
        for (int c = 0; (c = std::fgetc(errors)) != EOF;) {
            text += static_cast<char>(c);
        }
        return text;
    }

    int pid = 0;
    FILE* errors = nullptr;
    std::vector<Watch> nodes;
    std::vector<std::string> names;
};

}  // namespace

TEST_CASE("Ctrl-C and SIGTERM end the host in order, with their own exit code") {
    for (const int signal : {SIGINT, SIGTERM}) {
        const Bench bench;
        const HostProcess host(bench, {"gp.count=3"});
        CHECK(host.names == std::vector<std::string>{"host", "gp-0", "gp-1", "gp-2", "renderer-0",
                                                     "framebuffer-0"});
        ::kill(host.pid, signal);
        CHECK(host.wait() == 128 + signal);
        check_all_ended(host.nodes);
        const std::string text = host.error_text();
        CHECK_MESSAGE(text == (signal == SIGINT ? "error: interrupted by SIGINT\n"
                                                : "error: interrupted by SIGTERM\n"),
                      text);
        CHECK(bench.socket_folders() == 0);
    }
}

TEST_CASE("repeated Ctrl-C ends even nodes that will not") {
    const Bench bench;
    const HostProcess host(bench, {"gp.count=2", "gp.env=MISBEHAVE=deaf"});
    for (int i = 0; i < 3; ++i) {
        ::kill(host.pid, SIGINT);
    }
    CHECK(host.nodes.back().ends_within(limit_ms));
    CHECK(host.wait() == 130);
    check_all_ended(host.nodes);
    const std::string text = host.error_text();
    CHECK_MESSAGE(has(text, "still running: gp-0, gp-1; sending SIGKILL\n"), text);
    CHECK_MESSAGE(has(text, "\nerror: interrupted by SIGINT\n"), text);
}

TEST_CASE("nothing outlives a host that is killed") {
    const Bench bench;
    const HostProcess host(bench, {"gp.count=4"});
    CHECK(host.nodes.size() == 7);
    ::kill(host.pid, SIGKILL);
    CHECK(host.wait() == 137);
    check_all_ended(host.nodes, limit_ms);
}

TEST_CASE("the paper's 54 processes come up, answer and go down") {
    Bench bench;
    bench.topology = load_topology("paper-1993");
    Machine machine(bench.topology, bench.options);
    const std::vector<Watch> nodes = watch_nodes(machine);
    CHECK(nodes.size() == 53);
    ask_all(machine);
    machine.shutdown();
    check_all_ended(nodes);
}
