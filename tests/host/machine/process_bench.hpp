// Helpers for tests of real processes: a folder, and views of other processes.
#pragma once

#include <doctest/doctest.h>
#include <poll.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "host/machine/machine.hpp"

namespace pxpl5::test {

namespace fs = std::filesystem;

inline constexpr int limit_ms = 5000;  // For everyone to be gone, after a kill.

inline std::string text_of(const fs::path& path) {
    std::ostringstream text;
    text << std::ifstream(path).rdbuf();
    return text.str();
}

inline bool has(const std::string& text, const std::string& part) {
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
    host::MachineOptions options;
    host::Topology topology;
};

inline void check_all_ended(const std::vector<Watch>& watches, int timeout_ms = 0) {
    for (const Watch& watch : watches) {
        CHECK(watch.ends_within(timeout_ms));
    }
}

inline void ignore(const bus::Message&) {}
inline bool never() {
    return false;
}

/// The error that pumping on comes to.
inline host::MachineError end_of(host::Machine& machine) {
    try {
        machine.pump(ignore, never);
    } catch (const host::MachineError& error) {
        return error;
    }
    return {0, "no error"};
}

inline int pid_of(const host::Machine& machine, const std::string& name) {
    for (const host::Machine::Process& process : machine.processes()) {
        if (process.name == name) {
            return process.pid;
        }
    }
    FAIL(name, " is not there");
    return 0;
}

/// The io process of this process, which is no node of the ring.
inline int pid_of_io() {
    for (const auto& entry : fs::directory_iterator("/proc")) {
        const std::string stat = text_of(entry.path() / "stat");
        if (has(stat, "(pxpl5-io) ") && has(stat, " " + std::to_string(getpid()) + " ")) {
            return std::stoi(entry.path().filename());
        }
    }
    FAIL("there is no io process");
    return 0;
}

}  // namespace pxpl5::test
