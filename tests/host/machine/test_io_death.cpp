// The error of a request whose io process has died.
#include <doctest/doctest.h>

#include <csignal>
#include <filesystem>
#include <string>

#include "host/base/error.hpp"
#include "host/base/kernel/memory_kills.hpp"
#include "host/machine/launcher.hpp"
#include "tests/host/io/volume_files.hpp"

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
    io.memory = MemoryLack::perhaps;
    CHECK(text_of(io).find(fact + "The kernel ended a process of this computer") == 0);
    CHECK(text_of(io).find("perhaps this one: load a part with crop=") != std::string::npos);
    io.memory = MemoryLack::unknown;
    const std::string text = text_of(io);
    CHECK(text.find(fact + "A user or another program may have sent the signal: repeat the "
                           "command. If this happens again") == 0);
    CHECK(text.find("may have run out of memory") > text.find("may have sent"));
    CHECK(error_of(io).code == ExitCode::unavailable);
}

TEST_CASE("the file is not blamed for the crash of a process without a request") {
    IoDeath io = death_by(SIGSEGV);
    io.doing = "while it had no request";
    io.has_request = false;
    CHECK(text_of(io) ==
          "scan.dcm: io-0 was killed by signal 11 (SIGSEGV) while it had no request. The file is "
          "hardly the reason: repeat the command (log: io-0.log)");
    CHECK(error_of(io).code == ExitCode::unavailable);
    io.death = {"io-0", 1, 0};
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

namespace {

/// A computer's folders proc and sys/fs/cgroup.
class Computer {
  public:
    Computer() { write("proc/vmstat", "nr_free_pages 12\noom_kill 30\nnuma_hit 9\n"); }

    void write(const std::string& name, const std::string& text) const {
        std::filesystem::create_directories(
            std::filesystem::path(folder_.file(name)).parent_path());
        folder_.write(name, text);
    }
    void groups(const std::string& own, const std::string& mounts) const {
        write("proc/self/cgroup", own);
        write("proc/self/mountinfo", "22 27 0:21 / /proc rw,relatime - proc proc rw\n" + mounts);
    }
    /// "3 own", "30 wide" or "none".
    std::string kills() const {
        const auto kills = memory_kills(folder_.file(""));
        return kills ? std::to_string(kills->count) + (kills->is_own ? " own" : " wide") : "none";
    }

  private:
    pxpl5::test::TemporaryFolder folder_;
};

}  // namespace

TEST_CASE("kills for memory are counted in the own control group of version 2") {
    const Computer computer;
    computer.groups("0::/user/a\n",
                    "30 23 0:26 / /sys/fs/cgroup rw - cgroup2 cgroup2 rw,nsdelegate\n");
    CHECK(computer.kills() == "30 wide");                           // The group has no count.
    computer.write("sys/fs/cgroup/memory.events", "oom_kill 9\n");  // Of another group.
    CHECK(computer.kills() == "30 wide");
    computer.write("sys/fs/cgroup/user/a/memory.events", "max 7\noom 4\noom_kill 3\n");
    CHECK(computer.kills() == "3 own");
}

TEST_CASE("kills for memory are counted in the own control group of version 1") {
    const Computer computer;
    computer.groups("9:name=systemd:/\n4:cpu,memory:/process/a\n0::/\n",
                    "32 31 0:29 / /sys/fs/cgroup/cpu rw - cgroup cgroup rw,cpu\n"
                    "35 31 0:32 / /sys/fs/cgroup/memory rw shared:9 - cgroup cgroup rw,memory\n"
                    "41 31 0:38 / /sys/fs/cgroup/unified rw - cgroup2 cgroup2 rw\n");
    computer.write("sys/fs/cgroup/memory/memory.oom_control", "oom_kill 9\n");
    CHECK(computer.kills() == "30 wide");
    computer.write("sys/fs/cgroup/memory/process/a/memory.oom_control",
                   "oom_kill_disable 0\nunder_oom 0\noom_kill 3\n");
    CHECK(computer.kills() == "3 own");
}

TEST_CASE("the own control group of a container is its mounted folder") {
    const Computer computer;
    computer.write("sys/fs/cgroup/memory.events", "oom_kill 3\n");
    computer.write("sys/fs/cgroup/job/memory.events", "oom_kill 4\n");
    const std::string mount = "30 23 0:26 /docker/c1 /sys/fs/cgroup ro - cgroup2 cgroup rw\n";
    computer.groups("0::/docker/c1\n", mount);
    CHECK(computer.kills() == "3 own");
    computer.groups("0::/docker/c1/job\n", mount);
    CHECK(computer.kills() == "4 own");
    computer.groups("0::/\n", mount);  // A namespace of control groups hides the path.
    CHECK(computer.kills() == "3 own");
}

TEST_CASE("a computer without control groups counts for all, and an old kernel not at all") {
    const Computer computer;
    CHECK(computer.kills() == "30 wide");
    computer.write("proc/vmstat", "nr_free_pages 12\n");
    CHECK(computer.kills() == "none");
}

TEST_CASE("memory is blamed for sure only by the count of the own control group") {
    const MemoryKills own{3, true}, more{4, true}, wide{3, false}, wider{4, false};
    CHECK(memory_lack(own, own) == MemoryLack::none);
    CHECK(memory_lack(own, more) == MemoryLack::found);
    CHECK(memory_lack(wide, wide) == MemoryLack::none);
    CHECK(memory_lack(wide, wider) == MemoryLack::perhaps);
    CHECK(memory_lack(own, wider) == MemoryLack::unknown);
    CHECK(memory_lack(std::nullopt, own) == MemoryLack::unknown);
    CHECK(memory_lack(own, std::nullopt) == MemoryLack::unknown);
}
