#include "host/io/sandbox/every_thread.hpp"

#include <fmt/format.h>
#include <semaphore.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <ctime>
#include <filesystem>
#include <set>
#include <stdexcept>

namespace pxpl5::host::io {

namespace {

/// The signal with which glibc reaches all threads for setuid(). glibc keeps it out of the masks
/// that block "all" signals, and refuses sigaction() for it, so the system call sets the handler.
constexpr int broadcast_signal = 33;
constexpr int patience_s = 5;

/// The kernel's struct sigaction.
struct KernelAction {
    void (*handler)(int) = nullptr;
    unsigned long flags = 0;
    void (*restorer)() = nullptr;
    std::uint64_t mask = 0;
};

/// A signal handler sees only variables of static duration.
struct Broadcast {
    std::atomic<bool (*)()> act{nullptr};
    std::atomic<int> failures{0};
    sem_t answered{};
};
Broadcast broadcast;

void answer(int) {
    const int before = errno;
    if (!broadcast.act.load()()) {
        ++broadcast.failures;
    }
    sem_post(&broadcast.answered);
    errno = before;
}

/// Ids of the threads of this process, without this thread.
std::set<pid_t> other_threads() {
    std::set<pid_t> others;
    for (const auto& entry : std::filesystem::directory_iterator("/proc/self/task")) {
        const std::string name = entry.path().filename().string();
        pid_t id = 0;
        std::from_chars(name.data(), name.data() + name.size(), id);
        if (id != gettid()) {
            others.insert(id);
        }
    }
    return others;
}

KernelAction set_action(const KernelAction* action) {
    KernelAction before;
    if (syscall(SYS_rt_sigaction, broadcast_signal, action, &before, sizeof before.mask) != 0) {
        throw std::runtime_error("the signal that reaches all threads has no handler");
    }
    return before;
}

/// Waits for one answer.
void await_answer(const timespec& deadline) {
    while (sem_clockwait(&broadcast.answered, CLOCK_MONOTONIC, &deadline) != 0) {
        if (errno != EINTR) {
            throw std::runtime_error(
                fmt::format("a thread did not confine itself within {} s", patience_s));
        }
    }
}

void ask_others() {
    timespec deadline{};
    clock_gettime(CLOCK_MONOTONIC, &deadline);
    deadline.tv_sec += patience_s;
    std::set<pid_t> asked;
    for (bool more = true; more;) {
        more = false;
        for (const pid_t thread : other_threads()) {
            if (asked.insert(thread).second &&
                syscall(SYS_tgkill, getpid(), thread, broadcast_signal) == 0) {
                await_answer(deadline);
                more = true;  // The thread may have started another one before.
            }
        }
    }
}

}  // namespace

void in_every_thread(bool (*act)()) {
    broadcast.act = act;
    broadcast.failures = 0;
    sem_init(&broadcast.answered, 0, 0);
    if (!other_threads().empty()) {
        KernelAction action = set_action(nullptr);  // With the restorer that glibc has set.
        const KernelAction before = action;
        action.handler = &answer;
        set_action(&action);
        ask_others();
        set_action(&before);
    }
    if (!act() || broadcast.failures != 0) {
        throw std::runtime_error(fmt::format("{} threads could not confine themselves",
                                             std::max(broadcast.failures.load(), 1)));
    }
}

}  // namespace pxpl5::host::io
