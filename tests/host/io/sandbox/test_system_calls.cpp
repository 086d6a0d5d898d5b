// System calls of the sandbox of the io process, made by children that confine themselves.
#include <doctest/doctest.h>
#include <fcntl.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/un.h>

#include <atomic>
#include <csignal>
#include <cstdlib>
#include <functional>
#include <map>
#include <thread>

#include "host/io/sandbox/system_calls.hpp"
#include "tests/host/io/sandbox/confined.hpp"
#include "tests/host/io/sandbox/skipped.hpp"

using namespace pxpl5::host::io;
using namespace pxpl5::test;

namespace {

using Calls = std::map<std::string, std::function<long()>>;

/// How a reader that makes the call ends: the code is the error of the call, or 0.
Ending end_of(const std::function<long()>& call) {
    return in_child([&] {
        restrict_system_calls(Task::read);
        return error_of_call(call());
    });
}

/// Two connected sockets.
struct Connection {
    std::array<int, 2> ends{};
    Connection() { REQUIRE(socketpair(AF_UNIX, SOCK_STREAM, 0, ends.data()) == 0); }
    ~Connection() {
        close(ends[0]);
        close(ends[1]);
    }
    Connection(const Connection&) = delete;
    Connection& operator=(const Connection&) = delete;
};

}  // namespace

TEST_SUITE("host/io/system_calls") {
    TEST_CASE("calls of a program in foreign hands end the process, and the log names them") {
        if (lacks_filters()) {
            return;
        }
        const Connection connection;
        const int end = connection.ends[0];
        const pid_t parent = getpid();
        const sockaddr_un address{AF_UNIX, "/nowhere/socket"};
        const auto* place = reinterpret_cast<const sockaddr*>(&address);
        const Calls calls = {
            {"execve", [] { return execl("/bin/true", "true", nullptr); }},
            {"clone", [] { return syscall(SYS_clone, SIGCHLD, 0, 0, 0, 0); }},
            {"connect", [&] { return connect(end, place, sizeof address); }},
            {"bind", [&] { return bind(end, place, sizeof address); }},
            {"listen", [&] { return listen(end, 1); }},
            {"ptrace", [&] { return ptrace(PTRACE_ATTACH, parent, nullptr, nullptr); }},
            {"kill", [&] { return kill(parent, 0); }},
            {"tgkill", [&] { return tgkill(parent, parent, 0); }},
            {"process_vm_readv",
             [&] { return syscall(SYS_process_vm_readv, parent, nullptr, 0, nullptr, 0, 0); }},
            {"open_by_handle_at", [] { return syscall(SYS_open_by_handle_at, 0, nullptr, 0); }},
            {"mount", [] { return syscall(SYS_mount, nullptr, nullptr, nullptr, 0, nullptr); }},
            {"bpf", [] { return syscall(SYS_bpf, 0, nullptr, 0); }},
            {"keyctl", [] { return syscall(SYS_keyctl, 0, 0, 0, 0, 0); }},
            {"io_uring_setup", [] { return syscall(SYS_io_uring_setup, 1, nullptr); }},
        };
        for (const auto& [name, call] : calls) {
            CAPTURE(name);
            const Ending ending = end_of(call);
            CHECK(ending.signal == SIGSYS);
            CHECK(ending.log.starts_with("system call " + name + " ("));
        }
    }

    TEST_CASE("calls that a library may try fail") {
        if (lacks_filters()) {
            return;
        }
        constexpr int anonymous = MAP_PRIVATE | MAP_ANONYMOUS;
        const Calls calls = {
            {"socket", [] { return socket(AF_UNIX, SOCK_STREAM, 0); }},
            {"memfd_create", [] { return memfd_create("m", 0); }},
            {"prctl", [] { return prctl(PR_SET_PDEATHSIG, 0); }},
            {"fcntl F_SETOWN", [] { return fcntl(0, F_SETOWN, getppid()); }},
            {"ioctl TIOCSTI", [] { return syscall(SYS_ioctl, 0, 0x5412, nullptr); }},
            {"mprotect",
             [] {
                 void* page = mmap(nullptr, 4096, PROT_READ, anonymous, -1, 0);
                 return mprotect(page, 4096, PROT_READ | PROT_EXEC);
             }},
            {"mmap",
             [] {
                 void* page = mmap(nullptr, 4096, PROT_READ | PROT_EXEC, anonymous, -1, 0);
                 return page == MAP_FAILED ? -1 : 0;
             }},
        };
        for (const auto& [name, call] : calls) {
            CAPTURE(name);
            CHECK(end_of(call).code == EPERM);
        }
        const int listener = socket(AF_UNIX, SOCK_STREAM, 0);
        CHECK(end_of([&] { return accept(listener, nullptr, nullptr); }).code == EAGAIN);
        close(listener);
    }

    TEST_CASE("threads start and end, an open connection works, and abort() is SIGABRT") {
        if (lacks_filters()) {
            return;
        }
        const Connection connection;
        const Ending good = end_of([&]() -> long {
            std::thread([&] { send(connection.ends[0], "x", 1, 0); }).join();
            char byte = 0;
            return recv(connection.ends[1], &byte, 1, 0) == 1 && byte == 'x' ? 0 : -1;
        });
        CHECK(good.code == 0);
        const Ending aborted = end_of([]() -> long {
            std::signal(SIGABRT, SIG_DFL);  // Not the handler of doctest.
            std::abort();
        });
        CHECK(aborted.signal == SIGABRT);
    }

    TEST_CASE("a thread of ZeroMQ can start, and the scheduling stays as it is") {
        if (lacks_filters()) {
            return;
        }
        const Ending started = end_of([]() -> long {
            int failed = -1;
            std::thread([&] {  // As zmq::thread_t::applySchedulingParameters().
                int policy = 0;
                sched_param parameters{};
                failed = pthread_getschedparam(pthread_self(), &policy, &parameters);
                failed += pthread_setschedparam(pthread_self(), policy, &parameters);
            })
                .join();
            return failed == 0 ? 0 : -1;
        });
        CHECK(started.code == 0);
        const Ending same = end_of([]() -> long {
            const int policy = sched_getscheduler(0);
            const sched_param parameters{};
            const int other = policy == SCHED_BATCH ? SCHED_OTHER : SCHED_BATCH;
            const int failed = sched_setscheduler(0, other, &parameters);
            return failed == 0 && sched_getscheduler(0) == policy ? 0 : -1;
        });
        CHECK(same.code == 0);
    }

    TEST_CASE("a thread that ran before is filtered, too") {
        if (lacks_filters()) {
            return;
        }
        const Ending ending = in_child([] {
            std::atomic<int> step{0}, error{-1};
            std::thread library([&] {
                step.wait(0);
                error = error_of_call(socket(AF_UNIX, SOCK_STREAM, 0));
            });
            restrict_system_calls(Task::write);
            step = 1;
            step.notify_all();
            library.join();
            return error.load();
        });
        CHECK(ending.code == EPERM);
    }
}
