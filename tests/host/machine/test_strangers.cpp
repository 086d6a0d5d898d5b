// Processes that do not belong to a machine, and io processes that a file has taken over.
#include <doctest/doctest.h>
#include <fcntl.h>
#include <unistd.h>

#include <functional>
#include <string>

#include "host/base/error.hpp"
#include "host/machine/machine.hpp"
#include "tests/host/machine/idle_node.hpp"
#include "tests/host/machine/process_bench.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using namespace pxpl5::test;
namespace schema = bus::schema;

namespace {

/// Keeps what this process writes to standard error, while it lives.
class StandardError {
  public:
    explicit StandardError(const fs::path& file) : file_(file), before_(dup(STDERR_FILENO)) {
        const int fd = open(file.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600);
        dup2(fd, STDERR_FILENO);
        close(fd);
    }
    ~StandardError() {
        dup2(before_, STDERR_FILENO);
        close(before_);
    }
    StandardError(const StandardError&) = delete;
    StandardError& operator=(const StandardError&) = delete;
    std::string text() const { return text_of(file_); }

  private:
    fs::path file_;
    int before_;
};

/// Waits until a GP has answered once.
void check_works(Machine& machine) {
    bool answered = false;
    machine.send(machine.gp_ids()[0], order(Order::answer));
    machine.pump(
        [&](const bus::Message& message) {
            CHECK(message.kind() == schema::Body::VolumeReady);
            answered = true;
        },
        [&] { return answered; });
    CHECK(answered);
}

/// The error of the request that orders the io process to do `what`.
RequestError error_of_request(Machine& machine, Order what, ExitCode on_death) {
    machine.send(machine.start_io(on_death), io_order(what));
    try {
        machine.pump([](const bus::Message&) {}, [] { return false; });
    } catch (const RequestError& error) {
        return error;
    }
    return {ExitCode::usage, "no error"};
}

}  // namespace

TEST_CASE("a message that an io process may not send ends its request, not the machine") {
    Bench bench;
    Machine machine(bench.topology, bench.options);
    const RequestError error = error_of_request(machine, Order::forbidden, ExitCode::bad_data);
    CHECK(error.code == ExitCode::bad_data);
    CHECK_MESSAGE(
        has(error.what(), "io-0 broke the protocol and was killed: FrameDone from node 6"),
        error.what());
    check_works(machine);
    CHECK(error_of_request(machine, Order::forbidden, ExitCode::failed).code == ExitCode::failed);
    check_works(machine);
    machine.shutdown();
}

TEST_CASE("a damaged message of an io process ends its request, not the machine") {
    Bench bench;
    Machine machine(bench.topology, bench.options);
    for (int round = 0; round < 2; ++round) {
        const RequestError error = error_of_request(machine, Order::damaged, ExitCode::bad_data);
        CHECK(error.code == ExitCode::bad_data);
        // The name of the first process is free again once the process has ended.
        CHECK_MESSAGE(has(error.what(), " broke the protocol and was killed: "), error.what());
        CHECK_MESSAGE(has(error.what(), "nx is 0"), error.what());
        check_works(machine);
    }
    const bus::NodeId io = machine.start_io();  // The next io process serves.
    bool answered = false;
    machine.send(io, io_order(Order::answer));
    machine.pump([&](const bus::Message& m) { answered = m.source() == io; },
                 [&] { return answered; });
    machine.release_io();
    machine.shutdown();
}

TEST_CASE("an io process that writes in the name of a GP is dropped, named and counted") {
    for (const Transport transport : {Transport::ipc, Transport::tcp}) {
        Bench bench;
        bench.topology.ring.transport = transport;
        bench.options.insecure_tcp = true;  // The forger of the test has no keys.
        Machine machine(bench.topology, bench.options);
        const StandardError said(bench.folder / "said");
        const bus::NodeId io = machine.start_io();
        machine.send(io, io_order(Order::forge));
        bool answered = false;
        machine.pump([&](const bus::Message& m) { answered = answered || m.source() == io; },
                     [&] { return answered && machine.traffic().refused_messages > 0; });
        CHECK(machine.traffic().refused_messages == 1);
        check_works(machine);  // The numbers of the GP are as before.
        machine.shutdown();
        CHECK_MESSAGE(has(said.text(),
                          "warning: the ring dropped VolumeReady from node 1, on the "
                          "socket for nodes of role io; "),
                      said.text());
    }
}

TEST_CASE("a damaged message of a GP ends the machine, which names the node") {
    Bench bench;
    Machine machine(bench.topology, bench.options);
    machine.send(machine.gp_ids()[0], order(Order::damaged));
    std::string text;
    try {
        machine.pump([](const bus::Message&) {}, [] { return false; });
    } catch (const MachineError& error) {
        text = error.what();
    }
    CHECK_MESSAGE(has(text, "SurfaceBuilt 2 from node 1: slab is 4294967295"), text);
}

TEST_CASE("a message that a GP may not send is dropped, and missed when the next one comes") {
    Bench bench;
    Machine machine(bench.topology, bench.options);
    machine.send(machine.gp_ids()[0], order(Order::forbidden));
    std::string text;
    try {
        check_works(machine);
    } catch (const MachineError& error) {
        text = error.what();
    }
    CHECK_MESSAGE(has(text, "message 3 from node 1 came where 2 was due"), text);
    CHECK(machine.traffic().refused_messages == 1);
}

TEST_CASE("a Hello without the machine's secret does not end the start of the machine") {
    for (const Recording record : {Recording::off, Recording::full}) {
        Bench bench;
        bench.topology.record = record;
        bench.topology.gp.env = {"MISBEHAVE=secret"};
        Machine machine(bench.topology, bench.options);
        check_works(machine);
        CHECK(machine.traffic().refused_messages == 6);  // Three of each GP.
        machine.shutdown();
    }
}

TEST_CASE("children inherit the secret by a descriptor that they close") {
    Bench bench;
    Machine machine(bench.topology, bench.options);
    for (const Machine::Process& process : machine.processes()) {
        if (process.name == "host") {
            continue;
        }
        const fs::path proc = "/proc/" + std::to_string(process.pid);
        CHECK(has(text_of(proc / "cmdline"), std::string("--credentials-fd\0003", 18)));
        std::error_code none;
        CHECK(!has(fs::read_symlink(proc / "fd/3", none).string(), "pipe:"));
    }
    machine.shutdown();
}

TEST_CASE("a machine works over tcp with keys, and without only if that is asked for") {
    for (const bool insecure : {false, true}) {
        Bench bench;
        bench.topology.ring.transport = Transport::tcp;
        bench.options.insecure_tcp = insecure;
        Machine machine(bench.topology, bench.options);
        check_works(machine);
        machine.send(machine.start_io(), io_order(Order::answer));
        bool answered = false;
        machine.pump([&](const bus::Message&) { answered = true; }, [&] { return answered; });
        machine.release_io();
        machine.shutdown();
    }
}
