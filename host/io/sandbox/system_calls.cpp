#include "host/io/sandbox/system_calls.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sched.h>
#include <seccomp.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstring>
#include <initializer_list>
#include <stdexcept>
#include <string_view>

#include "host/base/kernel/protections.hpp"

namespace pxpl5::host::io {

namespace {

enum class Rule { always, to_write, chosen, fatal };

struct Call {
    Rule rule;
    int number;  ///< Below 0 if this architecture does not have the call.
    std::string_view name;
};

constexpr std::array calls = {
#define PXPL5_CALL(rule, name) Call{Rule::rule, SCMP_SYS(name), #name},
#include "host/io/sandbox/system_calls.def"
#undef PXPL5_CALL
};

void print(std::string_view text) {
    [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, text.data(), text.size());
}

/// Names the call in the log, and ends the process. Runs as a signal handler: system calls only.
void report_call(int signal, siginfo_t* facts, void*) {
    std::array<char, 16> digits{};
    const auto [end, failure] =
        std::to_chars(digits.data(), digits.data() + digits.size(), facts->si_syscall);
    print("system call ");
    for (const Call& call : calls) {
        if (call.number == facts->si_syscall) {
            print(call.name);
        }
    }
    print(" (");
    print({digits.data(), static_cast<std::size_t>(end - digits.data())});
    print(")\n");
    std::signal(signal, SIG_DFL);
    syscall(SYS_tgkill, getpid(), gettid(), signal);
}

void report_fatal_calls() {
    struct sigaction action {};
    action.sa_sigaction = &report_call;
    action.sa_flags = SA_SIGINFO;
    sigaction(SIGSYS, &action, nullptr);
}

/// A filter that is not in force yet. Calls without a rule fail with EPERM.
class Filter {
  public:
    Filter() : context_(seccomp_init(SCMP_ACT_ERRNO(EPERM))) {
        check(context_ == nullptr ? -ENOMEM : 0);
        check(seccomp_attr_set(context_, SCMP_FLTATR_CTL_TSYNC, 1));
        check(seccomp_attr_set(context_, SCMP_FLTATR_ACT_BADARCH, SCMP_ACT_KILL_PROCESS));
    }
    ~Filter() { seccomp_release(context_); }
    Filter(const Filter&) = delete;
    Filter& operator=(const Filter&) = delete;

    /// Applies `action` to calls whose arguments match all of `tests`.
    void add(std::uint32_t action, int call, std::initializer_list<scmp_arg_cmp> tests = {}) {
        if (call >= 0) {  // Below 0: another architecture has this call.
            check(seccomp_rule_add_array(context_, action, call,
                                         static_cast<unsigned>(tests.size()), tests.begin()));
        }
    }
    void allow(int call, std::initializer_list<scmp_arg_cmp> tests = {}) {
        add(SCMP_ACT_ALLOW, call, tests);
    }
    void load() { check(seccomp_load(context_)); }

  private:
    static void check(int result) {
        if (result != 0) {
            throw std::runtime_error(
                fmt::format("seccomp: cannot filter system calls: {}", std::strerror(-result)));
        }
    }

    scmp_filter_ctx context_;
};

constexpr scmp_arg_cmp is(unsigned argument, std::uint64_t value) {
    return {argument, SCMP_CMP_EQ, value, 0};
}
constexpr scmp_arg_cmp is_not(unsigned argument, std::uint64_t value) {
    return {argument, SCMP_CMP_NE, value, 0};
}
/// True if the bits of `mask` in the argument are those of `value`.
constexpr scmp_arg_cmp has_bits(unsigned argument, std::uint64_t mask, std::uint64_t value) {
    return {argument, SCMP_CMP_MASKED_EQ, mask, value};
}

/// Calls that are harmless with some arguments only.
void add_calls_with_arguments(Filter& filter) {
    const auto own = static_cast<std::uint64_t>(getpid());
    // Threads, but no processes. The flags of clone3 lie in memory, where no filter sees them;
    // without clone3, glibc uses clone.
    filter.allow(SCMP_SYS(clone), {has_bits(0, CLONE_THREAD, CLONE_THREAD)});
    filter.add(SCMP_ACT_TRAP, SCMP_SYS(clone), {has_bits(0, CLONE_THREAD, 0)});
    filter.add(SCMP_ACT_ERRNO(ENOSYS), SCMP_SYS(clone3));
    filter.allow(SCMP_SYS(tgkill), {is(0, own)});  // abort() and report_call().
    filter.add(SCMP_ACT_TRAP, SCMP_SYS(tgkill), {is_not(0, own)});
    // A thread of ZeroMQ that starts sets the scheduling policy that it has, and aborts if that
    // fails. It may start after the filter is in force. Nothing is changed, but the call succeeds.
    filter.add(SCMP_ACT_ERRNO(0), SCMP_SYS(sched_setscheduler));
    // ZeroMQ aborts after another error. It looks again, until the process ends.
    for (const int call : {SCMP_SYS(accept), SCMP_SYS(accept4)}) {
        filter.add(SCMP_ACT_ERRNO(EAGAIN), call);
    }
    for (const int call : {SCMP_SYS(mmap), SCMP_SYS(mprotect)}) {
        filter.allow(call, {has_bits(2, PROT_EXEC, 0)});
    }
    filter.allow(SCMP_SYS(sendto), {is(4, 0)});               // To the peer of the connection.
    filter.allow(SCMP_SYS(prlimit64), {is(0, 0), is(2, 0)});  // Reads limits, sets none.
    filter.allow(SCMP_SYS(prctl), {is(0, PR_SET_NAME)});
    for (const std::uint64_t request : {TCGETS + 0UL, FIONREAD + 0UL, FIONBIO + 0UL}) {
        filter.allow(SCMP_SYS(ioctl), {is(1, request)});
    }
    // Without F_SETOWN and F_SETSIG, which send signals to other processes.
    for (const int command : {F_DUPFD, F_DUPFD_CLOEXEC, F_GETFD, F_SETFD, F_GETFL, F_SETFL}) {
        filter.allow(SCMP_SYS(fcntl), {is(1, static_cast<std::uint64_t>(command))});
    }
}

void add_calls(Filter& filter, Task task) {
    for (const Call& call : calls) {
        if (call.rule == Rule::fatal) {
            filter.add(SCMP_ACT_TRAP, call.number);
        } else if (call.rule == Rule::always ||
                   (call.rule == Rule::to_write && task == Task::write)) {
            filter.allow(call.number);
        }
    }
}

}  // namespace

bool restrict_system_calls(Task task) {
    if (!has_system_call_filters()) {
        return false;
    }
    Filter filter;
    add_calls(filter, task);
    add_calls_with_arguments(filter);
    report_fatal_calls();
    filter.load();
    return true;
}

}  // namespace pxpl5::host::io
