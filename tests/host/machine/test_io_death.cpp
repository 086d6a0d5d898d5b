// The error of a request whose io process has died.
#include <doctest/doctest.h>

#include <csignal>
#include <sstream>

#include "host/base/error.hpp"
#include "host/base/kernel/memory_kills.hpp"
#include "host/machine/launcher.hpp"

using namespace pxpl5::host;

namespace {

IoDeath death_by(int signal) {
    IoDeath io;
    io.death = {"io-0", 0, signal};
    io.file = "scan.dcm";
    io.doing = "while reading a volume";
    io.log = "io-0.log";
    return io;
}

std::string text_of(const IoDeath& io) {
    return error_of(io).what();
}

}  // namespace

TEST_CASE("SIGKILL is blamed on memory only if the kernel says so") {
    IoDeath io = death_by(SIGKILL);
    const std::string fact =
        "scan.dcm: io-0 was killed by signal 9 (SIGKILL) while reading a volume. ";
    io.memory = MemoryLack::none;
    CHECK(text_of(io) == fact +
                             "The kernel did not end it for lack of memory, so a user or another "
                             "program sent the signal. Repeat the command (log: io-0.log)");
    io.memory = MemoryLack::found;
    CHECK(text_of(io).find(fact +
                           "The kernel ended a process at that time because this computer") == 0);
    CHECK(text_of(io).find("crop=") != std::string::npos);
    io.memory = MemoryLack::unknown;
    const std::string text = text_of(io);
    CHECK(text.find(fact + "A user or another program may have sent the signal: repeat the "
                           "command. If this happens again") == 0);
    CHECK(text.find("may have run out of memory") > text.find("may have sent"));
    CHECK(error_of(io).code == ExitCode::unavailable);
}

TEST_CASE("a crash names file, signal, work and the last words, and never memory") {
    IoDeath io = death_by(SIGSEGV);
    io.said = "words";
    CHECK(text_of(io) ==
          "scan.dcm: io-0 was killed by signal 11 (SIGSEGV) while reading a volume: words. The "
          "file may be damaged; if other programs read it, convert it with one of them (log: "
          "io-0.log)");
    CHECK(error_of(io).code == ExitCode::bad_data);
    io.otherwise = ExitCode::failed;  // A file that is written.
    CHECK(text_of(io).find("damaged") == std::string::npos);
    CHECK(error_of(io).code == ExitCode::failed);
    io = death_by(SIGXCPU);
    io.cpu_s = 300;
    CHECK(text_of(io).find("(SIGXCPU) while reading a volume. It had used its 300 s of processor "
                           "time. The file may be damaged") != std::string::npos);
}

TEST_CASE("the refusal of a library is the error, with the file once") {
    IoDeath io = death_by(0);
    io.death.exit_code = 65;
    io.otherwise = ExitCode::failed;
    io.said = "scan.dcm: a library refuses this file";
    CHECK(text_of(io) == "scan.dcm: a library refuses this file (log: io-0.log)");
    CHECK(error_of(io).code == ExitCode::bad_data);
    io.said = "a library refuses this file";
    CHECK(text_of(io) == "scan.dcm: a library refuses this file (log: io-0.log)");
    io.death.exit_code = 70;
    CHECK(text_of(io) ==
          "scan.dcm: io-0 ended with exit code 70 while reading a volume: a library refuses this "
          "file (log: io-0.log)");
}

TEST_CASE("the kernel's count of processes that it killed for memory is found by its name") {
    std::istringstream counts("nr_free_pages 12\noom_kill 3\nnuma_hit 9\n");
    CHECK(memory_kills_in(counts) == 3U);
    std::istringstream none("nr_free_pages 12\n");
    CHECK(!memory_kills_in(none));
}
