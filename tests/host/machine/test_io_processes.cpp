// Ids, logs and ends of io processes.
#include <doctest/doctest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <set>
#include <string>

#include "host/base/error.hpp"
#include "host/base/kernel/memory_kills.hpp"
#include "host/base/kernel/protections.hpp"
#include "host/machine/descriptors.hpp"
#include "host/machine/machine.hpp"
#include "tests/host/machine/idle_node.hpp"
#include "tests/host/machine/process_bench.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using namespace pxpl5::test;

namespace {

std::size_t io_logs(const fs::path& folder) {
    std::size_t count = 0;
    for (const auto& entry : fs::directory_iterator(folder)) {
        count += entry.path().filename().string().starts_with("io-") ? 1 : 0;
    }
    return count;
}

RequestError death_of_io(Machine& machine, int signal) {
    const bus::NodeId io = machine.start_io();
    bool answered = false;
    const auto answer = [&](const bus::Message& m) { answered = answered || m.source() == io; };
    machine.send(io, io_order(Order::answer));
    machine.pump(answer, [&] { return answered; });
    ::kill(pid_of_io(), signal);
    try {
        machine.pump(answer, never);
    } catch (const RequestError& error) {
        return error;
    }
    return {ExitCode::ok, "no error"};
}

/// A limit of descriptors for this process while it lives.
class Descriptors {
  public:
    explicit Descriptors(rlim_t soft) {
        getrlimit(RLIMIT_NOFILE, &before_);
        const rlimit low{soft, before_.rlim_max};
        setrlimit(RLIMIT_NOFILE, &low);
    }
    ~Descriptors() { setrlimit(RLIMIT_NOFILE, &before_); }
    Descriptors(const Descriptors&) = delete;
    Descriptors& operator=(const Descriptors&) = delete;
    static rlim_t soft() {
        rlimit now{};
        getrlimit(RLIMIT_NOFILE, &now);
        return now.rlim_cur;
    }

  private:
    rlimit before_{};
};

}  // namespace

TEST_CASE("ids and logs of io processes are used again") {
    Bench bench;
    bench.options.io_ids = 4;
    Machine machine(bench.topology, bench.options);
    std::set<bus::NodeId> ids;
    for (int round = 0; round < 12; ++round) {
        const bus::NodeId io = machine.start_io();
        ids.insert(io);
        bool answered = false;
        machine.send(io, io_order(Order::answer));
        machine.pump([&](const bus::Message& m) { answered = answered || m.source() == io; },
                     [&] { return answered; });
        machine.release_io();
    }
    CHECK(ids == std::set<bus::NodeId>{6, 7, 8, 9});
    CHECK(io_logs(machine.run_folder()) <= 3);
    machine.shutdown();
}

TEST_CASE("an io process that is killed is named with its work, and memory is not blamed") {
    Bench bench;
    Machine machine(bench.topology, bench.options);
    machine.name_work("scan.nii");
    const RequestError killed = death_of_io(machine, SIGKILL);
    CHECK(killed.code == ExitCode::unavailable);
    CHECK_MESSAGE(has(killed.what(), "scan.nii: io-0 was killed by signal 9 (SIGKILL) while it "),
                  killed.what());
    CHECK_MESSAGE(has(killed.what(), memory_kills() ? "The kernel did not end it for lack of memory"
                                                    : "another program may have sent the signal"),
                  killed.what());
    const RequestError aborted = death_of_io(machine, SIGABRT);
    CHECK(aborted.code == ExitCode::unavailable);  // This program takes no request.
    CHECK_MESSAGE(has(aborted.what(), "was killed by signal 6 (SIGABRT) while it had no request"),
                  aborted.what());
    // The log of a failure outlives the next process of the same name.
    const std::string text = aborted.what();
    const std::size_t at = text.find("(log: ") + 6;
    const fs::path log = text.substr(at, text.size() - at - 1);
    machine.start_io();
    CHECK_MESSAGE(has(text_of(log), "--host-endpoint"), log);
    machine.shutdown();
}

TEST_CASE("an io process that talks without end is killed, and the machine continues") {
    Bench bench;
    Machine machine(bench.topology, bench.options);
    machine.send(machine.start_io(), io_order(Order::chatter));
    int ends[2];
    REQUIRE(pipe(ends) == 0);
    std::string text;
    try {
        machine.wait_readable(ends[0]);  // The messages stay where they are.
    } catch (const RequestError& error) {
        text = error.what();
    }
    CHECK_MESSAGE(has(text, "io-0 broke the protocol and was killed: IoDone of "), text);
    CHECK_MESSAGE(has(text, "came from io-0 although 16384 messages"), text);
    ask_all(machine);
    machine.shutdown();
    close(ends[0]);
    close(ends[1]);
}

TEST_CASE("an io process that never says Hello fails its request, and the machine continues") {
    Bench bench;
    bench.options.start_timeout_s = 8;
    Machine machine(bench.topology, bench.options);
    setenv("MISBEHAVE", "silent", 1);
    machine.name_work("scan.nii");
    CHECK_THROWS_WITH_AS(machine.start_io(),
                         "scan.nii: io-0 has not said Hello within 8 s; the computer may be busy: "
                         "repeat the command",
                         RequestError);
    unsetenv("MISBEHAVE");
    bool answered = false;
    const bus::NodeId io = machine.start_io();
    machine.send(io, io_order(Order::answer));
    machine.pump([&](const bus::Message& m) { answered = answered || m.source() == io; },
                 [&] { return answered; });
    CHECK(answered);
    machine.shutdown();
}

TEST_CASE("an io process that its sandbox ends is no bad data: the error names the call") {
    if (!has_system_call_filters()) {
        MESSAGE("SKIPPED: this kernel has no seccomp filters");
        return;
    }
    Bench bench;
    Machine machine(bench.topology, bench.options);
    std::string text;
    ExitCode code = ExitCode::ok;
    machine.send(machine.start_io(ExitCode::bad_data), io_order(Order::start));
    try {
        machine.pump([](const bus::Message&) {}, never);
    } catch (const RequestError& error) {
        text = error.what();
        code = error.code;
    }
    CHECK(code == ExitCode::failed);
    CHECK_MESSAGE(has(text, "io-0 was ended by its sandbox: system call execve ("), text);
    CHECK_MESSAGE(has(text, "--no-io-sandbox"), text);
    CHECK_MESSAGE(has(text, "(log: "), text);
    machine.shutdown();
}

TEST_CASE("an io process has its sandbox unless the options switch the sandbox off") {
    for (const bool sandbox : {true, false}) {
        Bench bench;
        bench.options.io_sandbox = sandbox;
        Machine machine(bench.topology, bench.options);
        machine.start_io();
        const std::string words = text_of("/proc/" + std::to_string(pid_of_io()) + "/cmdline");
        CHECK(has(words, "--no-sandbox") != sandbox);
        machine.shutdown();
    }
}

TEST_CASE("a low soft limit of descriptors is raised, and a low hard limit is named") {
    const Descriptors few(80);
    Bench bench;
    bench.topology = load_topology("paper-1993");
    Machine machine(bench.topology, bench.options);
    CHECK(Descriptors::soft() >= needed_descriptors(54));
    machine.shutdown();
    rlimit limit{};
    getrlimit(RLIMIT_NOFILE, &limit);
    const std::size_t too_many = limit.rlim_max;
    std::string text;
    try {
        provide_descriptors(too_many);
    } catch (const RequestError& error) {
        CHECK(error.code == ExitCode::unavailable);
        text = error.what();
    }
    CHECK_MESSAGE(has(text, std::to_string(too_many) + " nodes needs "), text);
    CHECK_MESSAGE(has(text, "but the hard limit is " + std::to_string(too_many)), text);
}

TEST_CASE("a machine ends although the parent of its program has blocked SIGCHLD") {
    sigset_t child_signal, before;
    sigemptyset(&child_signal);
    sigaddset(&child_signal, SIGCHLD);
    pthread_sigmask(SIG_BLOCK, &child_signal, &before);
    {
        Bench bench;
        Machine machine(bench.topology, bench.options);
        machine.shutdown();
    }
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
}
