// Nodes that are alive, but do not answer.
#include <doctest/doctest.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <string>
#include <vector>

#include "host/base/error.hpp"
#include "host/machine/launcher.hpp"
#include "host/machine/machine.hpp"
#include "tests/host/machine/idle_node.hpp"
#include "tests/host/machine/process_bench.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using namespace pxpl5::test;

namespace {

struct Quick : Bench {
    Quick() { topology.heartbeat = {50, 20, 3}; }
};

}  // namespace

TEST_CASE("a node that is stopped is named and ends the machine, whichever it is") {
    for (const char* name : {"gp-1", "renderer-0", "framebuffer-0"}) {
        Quick bench;
        Machine machine(bench.topology, bench.options);
        std::vector<Watch> nodes;
        for (const Machine::Process& process : machine.processes()) {
            if (process.name != "host") {
                nodes.emplace_back(process.pid);
            }
        }
        std::vector<std::string> told;
        machine.tell_suspects([&told](const std::string& text) { told.push_back(text); });
        ::kill(pid_of(machine, name), SIGSTOP);
        const MachineError error = end_of(machine);
        REQUIRE(told.size() == 1);
        CHECK_MESSAGE(has(told[0], "has not answered for"), told[0]);
        CHECK_MESSAGE(told[0].starts_with(name), told[0]);
        CHECK(error.code == timeout_code);
        CHECK_MESSAGE(has(error.what(), std::string(name) + " (process "), error.what());
        CHECK_MESSAGE(has(error.what(), "does not answer: last heard 1."), error.what());
        // A node that was quick to stop still took Go.
        const bool is_told = has(error.what(), " s ago while it waited for messages; ") ||
                             has(error.what(), " s ago while it took Go; ");
        CHECK_MESSAGE(is_told, error.what());
        CHECK_MESSAGE(has(error.what(),
                          "; the process is stopped (SIGSTOP); the limit is 1.0 s "
                          "(heartbeat.misses 20 of 50 ms)"),
                      error.what());
        check_all_ended(nodes);
    }
}

TEST_CASE("a stopped node is found while the host waits for input, too") {
    Quick bench;
    Machine machine(bench.topology, bench.options);
    std::array<int, 2> ends{};
    REQUIRE(pipe(ends.data()) == 0);
    ::kill(pid_of(machine, "gp-0"), SIGSTOP);
    CHECK_THROWS_AS(machine.wait_readable(ends[0]), MachineError);
    close(ends[0]);
    close(ends[1]);
}

TEST_CASE("a node whose work does not move on is stuck, although its process is alive") {
    Quick bench;
    Machine machine(bench.topology, bench.options);
    machine.send(machine.gp_ids()[1], order(Order::hang));
    const MachineError error = end_of(machine);
    CHECK(error.code == timeout_code);
    CHECK_MESSAGE(has(error.what(), "gp-1 (process "), error.what());
    CHECK_MESSAGE(has(error.what(), "is stuck: no progress for 3."), error.what());
    CHECK_MESSAGE(has(error.what(), "while it took RemoveSurface; heartbeat.stuck_s is 3"),
                  error.what());
}

TEST_CASE("a stopped io process fails its request, and the machine continues") {
    Quick bench;
    Machine machine(bench.topology, bench.options);
    machine.start_io();
    ::kill(pid_of_io(), SIGSTOP);
    std::string text;
    try {
        machine.pump(ignore, never);
    } catch (const RequestError& error) {
        CHECK(error.code == ExitCode::failed);
        text = error.what();
    }
    CHECK_MESSAGE(has(text, "io-0 (process "), text);
    CHECK_MESSAGE(has(text, "does not answer"), text);
    CHECK_MESSAGE(has(text,
                      "The host has ended this process: repeat the command. With --set "
                      "heartbeat.misses=0"),
                  text);
    machine.start_io();
    machine.shutdown();
}

TEST_CASE("a process that is stopped before it says Hello is found by the heartbeat") {
    Quick bench;
    Machine machine(bench.topology, bench.options);
    machine.prepare_io();
    ::kill(pid_of_io(), SIGSTOP);
    std::string text;
    try {
        machine.start_io();
        machine.pump(ignore, never);
    } catch (const RequestError& error) {
        text = error.what();
    }
    CHECK_MESSAGE(has(text, "io-0 (process "), text);
    CHECK_MESSAGE(has(text, "does not answer"), text);
    machine.shutdown();
}

TEST_CASE("an answer that no node works on is missed after the limit, with the name of the work") {
    Quick bench;
    Machine machine(bench.topology, bench.options);
    machine.name_work("surface bone");
    const MachineError error = end_of(machine);
    CHECK(error.code == timeout_code);
    CHECK_MESSAGE(
        has(error.what(), "surface bone: no answer, although no node has had work for 1."),
        error.what());
}

TEST_CASE("a removed folder of sockets is the cause that is named") {
    Quick bench;
    Machine machine(bench.topology, bench.options);
    for (const auto& entry : fs::directory_iterator(bench.folder)) {
        if (entry.path().filename().string().starts_with("pxpl5-")) {
            fs::remove_all(entry.path());
        }
    }
    const MachineError error = end_of(machine);
    CHECK_MESSAGE(has(error.what(), "because the socket /"), error.what());
    CHECK_MESSAGE(has(error.what(), "/host was removed"), error.what());
    CHECK_MESSAGE(has(error.what(), "XDG_RUNTIME_DIR"), error.what());
}

TEST_CASE("no node of a machine without a heartbeat beats, so that a debugger may stop it") {
    Quick bench;
    bench.topology.heartbeat.misses = 0;
    Machine machine(bench.topology, bench.options);
    const int pid = pid_of(machine, "gp-0");
    CHECK_MESSAGE(!has(text_of("/proc/" + std::to_string(pid) + "/cmdline"), "--pulse-fd"),
                  "the node beats although no host looks");
    machine.shutdown();
}
