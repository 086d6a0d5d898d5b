#include <doctest/doctest.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <string>
#include <vector>

#include "host/base/error.hpp"
#include "host/machine/launcher.hpp"
#include "host/machine/machine.hpp"
#include "ringbus/process/process.hpp"
#include "tests/host/machine/idle_node.hpp"
#include "tests/host/machine/process_bench.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using namespace pxpl5::test;
namespace schema = bus::schema;

namespace {

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

TEST_CASE("a node that is killed by name is dead at once, and the next thing done tells") {
    Bench bench;
    Machine machine(bench.topology, bench.options);
    const std::vector<MachineNode> nodes = machine.nodes();
    REQUIRE(nodes.size() == 6);
    CHECK(nodes[0].name == "host");
    CHECK(nodes[4].name == "renderer-1");
    CHECK(nodes[4].role == schema::Role::renderer);
    const Watch killed(pid_of(machine, "renderer-1"));
    machine.kill(nodes[4].id);
    CHECK(killed.ends_within(0));
    const MachineError error = end_of(machine);
    CHECK(error.code == 137);
    CHECK_MESSAGE(has(error.what(), "renderer-1 was killed by signal 9 (SIGKILL)"), error.what());
    CHECK_THROWS_AS(machine.kill(nodes[1].id), MachineError);
}

TEST_CASE("a node that gives up ends the machine with its exit code and its last words") {
    Bench bench;
    Machine machine(bench.topology, bench.options);
    const std::vector<Watch> nodes = watch_nodes(machine);
    machine.send(machine.gp_ids()[1], order(Order::exit_70));
    const MachineError error = end_of(machine);
    CHECK(error.code == 70);
    CHECK_MESSAGE(has(error.what(), "gp-1 ended with exit code 70: error: as ordered"),
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
    bench.options.drain_ms = 2000;  // The other nodes end by themselves, also on a busy computer.
    Machine machine(bench.topology, bench.options);
    const std::vector<Watch> nodes = watch_nodes(machine);
    std::string text;
    try {
        machine.shutdown();
    } catch (const MachineError& error) {
        CHECK(error.code == 124);
        text = error.what();
    }
    CHECK_MESSAGE(
        has(text,
            "framebuffer-0 did not end after Shutdown. The host ended framebuffer-0 with SIGKILL"),
        text);
    check_all_ended(nodes);
}

TEST_CASE("an io process comes and goes, and its death is the request's error, not the machine's") {
    Bench bench;
    Machine machine(bench.topology, bench.options);
    for (int round = 0; round < 3; ++round) {
        const bus::NodeId io = machine.start_io();
        CHECK(has(machine.node_name(io), "io-"));
        bool answered = false;
        machine.send(io, io_order(Order::answer));
        machine.pump([&](const bus::Message& m) { answered = answered || m.source() == io; },
                     [&] { return answered; });
        machine.release_io();
        ask_all(machine);
    }
    machine.send(machine.start_io(), io_order(Order::abort));
    std::string text;
    try {
        machine.pump(ignore, never);
    } catch (const RequestError& error) {
        CHECK(error.code == ExitCode::bad_data);
        text = error.what();
    }
    CHECK_MESSAGE(has(text, " was killed by signal 6 (SIGABRT)"), text);
    ask_all(machine);
    machine.start_io();
    ask_all(machine);
    machine.shutdown();
}

TEST_CASE("a prepared io process is the next one that is started, or ends with the machine") {
    Bench bench;
    Machine machine(bench.topology, bench.options);
    machine.prepare_io();
    machine.prepare_io();  // One is enough.
    ask_all(machine);      // Its Hello may come now: it is no answer to anything.
    const bus::NodeId io = machine.start_io();
    CHECK(machine.node_name(io) == "io-0");
    bool answered = false;
    machine.send(io, io_order(Order::answer));
    machine.pump([&](const bus::Message& m) { answered = answered || m.source() == io; },
                 [&] { return answered; });
    machine.release_io();
    machine.prepare_io();
    CHECK(has(machine.node_name(machine.start_io()), "io-"));
    machine.release_io();
    machine.prepare_io();
    ask_all(machine);
    machine.shutdown();  // Throws if the third is in its way.
}

TEST_CASE(
    "Ctrl-C ends what may be canceled, with its io process, and the next one ends the machine") {
    Bench bench;
    Machine machine(bench.topology, bench.options);
    machine.start_io();
    machine.allow_cancel(true);
    ::kill(getpid(), SIGINT);
    CHECK_THROWS_WITH_AS(machine.pump(ignore, never), "canceled", Canceled);
    ask_all(machine);  // The io process's death is not an error.
    machine.allow_cancel(true);
    ::kill(getpid(), SIGINT);
    CHECK_THROWS_AS(machine.start_io(), Canceled);
    ask_all(machine);
    ::kill(getpid(), SIGINT);
    CHECK(end_of(machine).code == 130);
}

TEST_CASE("during a command of a prompt, Ctrl-C cancels the next work that may be canceled") {
    Bench bench;
    Machine machine(bench.topology, bench.options);
    const auto press = [] { ::kill(getpid(), SIGINT); };
    machine.cancel_on_interrupt(true);
    press();
    ask_all(machine);  // This may not be canceled, and is done first.
    machine.allow_give_up(true);
    CHECK_THROWS_WITH_AS(machine.pump(ignore, never), "canceled", Canceled);
    machine.allow_give_up(false);
    ask_all(machine);
    machine.cancel_on_interrupt(false);

    machine.cancel_on_interrupt(true);
    press();
    ask_all(machine);
    machine.allow_cancel(true);  // As a load does.
    CHECK_THROWS_AS(machine.pump(ignore, never), Canceled);
    machine.allow_cancel(false);
    machine.cancel_on_interrupt(false);

    machine.cancel_on_interrupt(true);
    press();
    machine.cancel_on_interrupt(false);  // The command has ended before anybody looked.
    machine.allow_give_up(true);
    ask_all(machine);
    machine.allow_give_up(false);

    machine.cancel_on_interrupt(true);
    press();
    ask_all(machine);
    machine.cancel_on_interrupt(false);  // Nothing of the command could be canceled.
    machine.allow_give_up(true);
    ask_all(machine);
    machine.allow_give_up(false);

    machine.cancel_on_interrupt(true);
    press();
    ask_all(machine);
    press();
    CHECK(end_of(machine).code == 130);
}

TEST_CASE("SIGTERM ends the machine, whatever may be canceled") {
    Bench bench;
    Machine machine(bench.topology, bench.options);
    machine.allow_cancel(true);
    ::kill(getpid(), SIGTERM);
    CHECK(end_of(machine).code == 143);
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

TEST_CASE("a node that talks without end while nobody listens ends the machine") {
    static_assert(chatter_messages > host::max_backlog_messages);
    Bench bench;
    Machine machine(bench.topology, bench.options);
    machine.send(machine.gp_ids()[1], order(Order::chatter));
    int ends[2];
    REQUIRE(pipe(ends) == 0);
    std::string text;
    try {
        machine.wait_readable(ends[0]);
    } catch (const MachineError& error) {
        CHECK(error.code == 1);
        text = error.what();
    }
    CHECK_MESSAGE(has(text, "came from gp-1 although 16384 messages"), text);
    close(ends[0]);
    close(ends[1]);
}

TEST_CASE("the death of an io process fails with the exit code that its start was given") {
    Bench bench;
    Machine machine(bench.topology, bench.options);
    for (const ExitCode code : {ExitCode::failed, ExitCode::bad_data}) {
        machine.send(machine.start_io(code), io_order(Order::abort));
        std::optional<ExitCode> found;
        try {
            machine.pump([](const bus::Message&) {}, [] { return false; });
        } catch (const RequestError& error) {
            found = error.code;
        }
        CHECK(found == code);
    }
    machine.shutdown();
}
