#include <doctest/doctest.h>
#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "host/machine/port.hpp"
#include "host/machine/processes/kept_signals.hpp"
#include "host/machine/processes/supervisor.hpp"

using namespace pxpl5::host;

namespace {

struct Bench {
    Bench() {
        std::string pattern = std::filesystem::temp_directory_path() / "pxpl5-test-XXXXXX";
        REQUIRE(mkdtemp(pattern.data()) != nullptr);
        folder = pattern;
    }
    ~Bench() { std::filesystem::remove_all(folder); }

    int shell(const std::string& name, const std::string& script) {
        return supervisor.spawn(
            {name, "/bin/sh", {"-c", script}, {}, -1, folder / (name + ".log")});
    }
    Death next_death() {
        for (;;) {
            supervisor.wait(-1, -1);
            const std::vector<Death> deaths = supervisor.take_deaths();
            if (!deaths.empty()) {
                REQUIRE(deaths.size() == 1);
                return deaths[0];
            }
        }
    }
    std::string log(const std::string& name) const {
        std::ostringstream text;
        text << std::ifstream(folder / (name + ".log")).rdbuf();
        return text.str();
    }

    std::filesystem::path folder;
    Supervisor supervisor;
};

bool exists(int pid) {
    return ::kill(pid, 0) == 0;
}

}  // namespace

TEST_CASE("the end of a process that does not obey is awaited no longer than said") {
    Bench bench;
    // It computes until it has used 3 s of processor time: a wait without limit would see its end.
    const int stubborn =
        bench.shell("gp-0", "trap '' TERM; ulimit -t 3; echo ready; while :; do :; done");
    while (bench.log("gp-0").find("\nready\n") == std::string::npos) {
        bench.supervisor.wait(-1, 10);
    }
    bench.supervisor.end("gp-0", SIGTERM, 20);
    CHECK(bench.supervisor.take_deaths().empty());
    CHECK(exists(stubborn));
    bench.supervisor.end("gp-0", SIGKILL);
    const std::vector<Death> deaths = bench.supervisor.take_deaths();
    REQUIRE(deaths.size() == 1);
    CHECK(deaths[0].signal == SIGKILL);
}

TEST_CASE("a process that ends is reported by name and exit code") {
    Bench bench;
    bench.shell("gp-3", "exit 70");
    const Death death = bench.next_death();
    CHECK(death.text() == "gp-3 ended with exit code 70");
    CHECK(death.code() == 70);
    CHECK(bench.supervisor.running().empty());
}

TEST_CASE("a process that is killed is reported by name and signal") {
    Bench bench;
    const int pid = bench.shell("gp-3", "kill -STOP $$");  // Runs until the supervisor ends it.
    CHECK(bench.supervisor.running() == std::vector<std::string>{"gp-3"});
    ::kill(pid, SIGKILL);
    const Death death = bench.next_death();
    CHECK(death.text() == "gp-3 was killed by signal 9 (SIGKILL)");
    CHECK(death.code() == 137);
    CHECK_FALSE(exists(pid));
}

TEST_CASE("what a process prints is in its log, under the line that started it") {
    Bench bench;
    bench.supervisor.spawn({"io-1",
                            "/bin/sh",
                            {"-c", "echo \"$WORD\"; echo oops >&2"},
                            {"WORD=hello"},
                            0,
                            bench.folder / "io-1.log"});
    CHECK(bench.next_death().exit_code == 0);
    CHECK(bench.log("io-1") == "io-1: /bin/sh -c echo \"$WORD\"; echo oops >&2\nhello\noops\n");
}

TEST_CASE("a program that is not there is an error that names it") {
    Bench bench;
    std::string text;
    try {
        bench.supervisor.spawn(
            {"gp-0", "/no/such/pxpl5-gp", {}, {}, -1, bench.folder / "gp-0.log"});
    } catch (const MachineError& error) {
        text = error.what();
        CHECK(error.code == 69);
    }
    CHECK(text == "gp-0 cannot start: /no/such/pxpl5-gp: no such file or directory");
    CHECK(bench.supervisor.running().empty());
}

TEST_CASE("a signal reaches the whole process group") {
    Bench bench;
    // The shell's own child holds the pipe open; reading ends when both are gone.
    int ends[2];
    REQUIRE(pipe(ends) == 0);
    bench.supervisor.spawn(
        {"a",
         "/bin/sh",
         {"-c", "/bin/sh -c 'echo up; kill -STOP $$' >/proc/" + std::to_string(getpid()) + "/fd/" +
                    std::to_string(ends[1]) + " & wait"},
         {},
         -1,
         bench.folder / "a.log"});
    char text[8];
    REQUIRE(read(ends[0], text, sizeof text) == 3);
    close(ends[1]);
    bench.supervisor.kill_all(SIGKILL);
    CHECK(bench.next_death().signal == SIGKILL);
    CHECK(read(ends[0], text, sizeof text) == 0);
    close(ends[0]);
}

TEST_CASE("the supervisor takes its processes along") {
    int pid = 0;
    {
        Bench bench;
        pid = bench.shell("stuck", "trap '' TERM; kill -STOP $$");
        CHECK(exists(pid));
    }
    CHECK_FALSE(exists(pid));
}

TEST_CASE("SIGINT, SIGTERM and SIGHUP are counted, not obeyed") {
    Bench bench;
    CHECK(bench.supervisor.take_interrupt() == 0);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
        ::kill(getpid(), signal);
        bench.supervisor.wait(-1, -1);
        CHECK(bench.supervisor.take_interrupt() == signal);
        CHECK(bench.supervisor.take_interrupt() == 0);
    }
}

TEST_CASE("signals between two supervisors are kept, and those that one has counted are not") {
    const KeptSignals kept;
    {
        Bench bench;
        ::kill(getpid(), SIGINT);
        bench.supervisor.wait(-1, -1);
        CHECK(bench.supervisor.take_interrupt() == SIGINT);
        ::kill(getpid(), SIGHUP);  // Left to the next one.
    }
    ::kill(getpid(), SIGTERM);
    Bench bench;
    CHECK(bench.supervisor.take_interrupt() == SIGHUP);
    CHECK(bench.supervisor.take_interrupt() == SIGTERM);
    CHECK(bench.supervisor.take_interrupt() == 0);
}

TEST_CASE("waiting ends when the descriptor is readable, or in time") {
    Bench bench;
    int ends[2];
    REQUIRE(pipe(ends) == 0);
    bench.supervisor.wait(ends[0], 0);
    bench.supervisor.wait(ends[0], 1);
    REQUIRE(write(ends[1], "x", 1) == 1);
    bench.supervisor.wait(ends[0], -1);
    close(ends[0]);
    close(ends[1]);
}

TEST_CASE("a wait for input ends with the input, with its end, and with a death") {
    Bench bench;
    int ends[2];
    REQUIRE(pipe(ends) == 0);
    CHECK_FALSE(bench.supervisor.wait_input(-1, ends[0], 0));  // Does not wait.
    bench.shell("gp-0", "exit 1");
    CHECK_FALSE(bench.supervisor.wait_input(-1, ends[0]));
    CHECK(bench.supervisor.take_deaths().size() == 1);
    REQUIRE(write(ends[1], "x", 1) == 1);
    CHECK(bench.supervisor.wait_input(-1, ends[0]));
    char byte = 0;
    REQUIRE(read(ends[0], &byte, 1) == 1);
    CHECK((fcntl(ends[0], F_GETFL) & O_NONBLOCK) == 0);  // It is shared with others.
    close(ends[1]);
    CHECK(bench.supervisor.wait_input(-1, ends[0]));
    close(ends[0]);
    CHECK(bench.supervisor.wait_input(-1, ends[0]));  // Closed.
}

TEST_CASE("files on disk are always readable") {
    Bench bench;
    const int file = open("/proc/self/exe", O_RDONLY);
    CHECK(bench.supervisor.wait_input(-1, file));
    close(file);
}
