#include "host/base/kernel/run_program.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>

#include "host/base/error.hpp"
#include "host/base/kernel/owned_descriptor.hpp"

namespace pxpl5::host {

namespace {

constexpr int kill_ms = 5000;  // A killed process ends late while the kernel waits for a disk.

[[noreturn]] void refuse(const std::string& program, int error) {
    throw RequestError(ExitCode::unavailable,
                       fmt::format("{} cannot start: {}", program, std::strerror(error)));
}

/// Returns a new file in memory.
int open_memory(const std::string& program, const char* name) {
    const int fd = memfd_create(name, MFD_CLOEXEC | MFD_ALLOW_SEALING);
    if (fd < 0) {
        refuse(program, errno);
    }
    return fd;
}

/// Makes writes past the limit fail, so that the output cannot fill the memory.
void limit_output(const std::string& program, const OwnedDescriptor& file, std::size_t bytes) {
    if (ftruncate(file.fd, static_cast<off_t>(bytes)) < 0 ||
        fcntl(file.fd, F_ADD_SEALS, F_SEAL_GROW) < 0) {
        refuse(program, errno);
    }
}

/// Returns what the program has written. The program shares the file's offset.
std::string text_of(const OwnedDescriptor& file, std::size_t most_bytes) {
    const auto size =
        std::clamp<off_t>(lseek(file.fd, 0, SEEK_CUR), 0, static_cast<off_t>(most_bytes));
    std::string text(static_cast<std::size_t>(size), '\0');
    const ssize_t got = pread(file.fd, text.data(), text.size(), 0);
    text.resize(static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
    return text;
}

/// Starts the program in a process group of its own, with the default mask of signals.
pid_t start(std::vector<std::string>& words, const std::array<int, 3>& streams) {
    std::vector<char*> arguments;
    for (std::string& word : words) {
        arguments.push_back(word.data());
    }
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    for (std::size_t stream = 0; stream < streams.size(); ++stream) {
        posix_spawn_file_actions_adddup2(&actions, streams[stream], static_cast<int>(stream));
    }
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    sigset_t none;
    sigemptyset(&none);
    posix_spawnattr_setsigmask(&attributes, &none);
    posix_spawnattr_setpgroup(&attributes, 0);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETPGROUP);
    pid_t pid = 0;
    const int error =
        posix_spawnp(&pid, arguments[0], &actions, &attributes, arguments.data(), environ);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&actions);
    if (error != 0) {
        refuse(words[0], error);
    }
    return pid;
}

/// Returns whether the process has ended within the time, and before `stop_fd` is readable.
bool ends_in_time(const OwnedDescriptor& process, int limit_ms, int stop_fd) {
    using Clock = std::chrono::steady_clock;
    std::array<pollfd, 2> polled{{{process.fd, POLLIN, 0}, {stop_fd, POLLIN, 0}}};
    const Clock::time_point end = Clock::now() + std::chrono::milliseconds(limit_ms);
    int ready = -1;
    do {
        const auto left = std::chrono::ceil<std::chrono::milliseconds>(end - Clock::now());
        ready =
            poll(polled.data(), polled.size(), static_cast<int>(std::max<long>(left.count(), 0)));
    } while (ready < 0 && errno == EINTR);
    return ready > 0 && polled[0].revents != 0;
}

/// Waits for the end of the process. Returns its exit code, or 128 + signal.
int code_of(pid_t pid) {
    int status = 0;
    while (waitpid(pid, &status, 0) < 0 && errno == EINTR) {
    }
    return WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
}

}  // namespace

ProgramEnd run_program(std::vector<std::string> words, std::string_view input, int limit_ms,
                       int stop_fd, std::size_t out_bytes) {
    const OwnedDescriptor in(open_memory(words[0], "in")), out(open_memory(words[0], "out")),
        errors(open_memory(words[0], "errors"));
    limit_output(words[0], out, out_bytes);
    limit_output(words[0], errors, max_output_bytes);
    if (::write(in.fd, input.data(), input.size()) != static_cast<ssize_t>(input.size())) {
        refuse(words[0], errno);
    }
    lseek(in.fd, 0, SEEK_SET);
    const pid_t pid = start(words, {in.fd, out.fd, errors.fd});
    const OwnedDescriptor process(static_cast<int>(syscall(SYS_pidfd_open, pid, 0)));
    if (process.fd < 0) {
        const int error = errno;
        kill(-pid, SIGKILL);
        (void)code_of(pid);
        throw RequestError(ExitCode::unavailable,
                           fmt::format("{} cannot be watched: {}. This needs Linux 5.3 or later, "
                                       "and a free file descriptor ('ulimit -n' shows the limit)",
                                       words[0], std::strerror(error)));
    }
    ProgramEnd end;
    end.is_in_time = ends_in_time(process, limit_ms, stop_fd);
    if (!end.is_in_time) {
        kill(-pid, SIGKILL);
    }
    const bool has_ended = end.is_in_time || ends_in_time(process, kill_ms, -1);
    end.code = has_ended ? code_of(pid) : 128 + SIGKILL;
    end.out = text_of(out, out_bytes);
    end.errors = text_of(errors, max_output_bytes);
    return end;
}

}  // namespace pxpl5::host
