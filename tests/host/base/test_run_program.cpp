#include "host/base/kernel/run_program.hpp"

#include <doctest/doctest.h>
#include <pthread.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <csignal>
#include <string>

#include "host/base/error.hpp"

using namespace pxpl5::host;

namespace {

constexpr int limit_ms = 60'000;

}  // namespace

TEST_CASE("a program gets its input, and its output, errors and exit code come back") {
    const ProgramEnd end = run_program(
        {"sh", "-c", "read line; echo \"<$line>\"; echo no >&2; exit 3"}, "a b\n", limit_ms);
    CHECK(end.out == "<a b>\n");
    CHECK(end.errors == "no\n");
    CHECK(end.code == 3);
    CHECK(end.is_in_time);
}

TEST_CASE("a program that runs too long is killed with its children") {
    const ProgramEnd end =
        run_program({"sh", "-c", "echo begun; tail -f /dev/null | tail -f /dev/null"}, "", 500);
    CHECK_FALSE(end.is_in_time);
    CHECK(end.code == 128 + SIGKILL);
    CHECK(end.out == "begun\n");
}

TEST_CASE("a flood of output fails at 64 KiB") {
    const ProgramEnd end =
        run_program({"sh", "-c", "dd if=/dev/zero bs=4096; echo $? >&2"}, "", limit_ms);
    CHECK(end.is_in_time);
    CHECK(end.out == std::string(65'536, '\0'));
    CHECK(end.errors.ends_with("\n1\n"));
}

TEST_CASE("a descriptor that is readable ends a program at once") {
    const int stop = eventfd(1, EFD_CLOEXEC);
    CHECK_FALSE(run_program({"tail", "-f", "/dev/null"}, "", limit_ms, stop).is_in_time);
    close(stop);
}

TEST_CASE("a program has its own process group, and no blocked signals") {
    sigset_t blocked, before;
    sigemptyset(&blocked);
    sigaddset(&blocked, SIGTERM);
    pthread_sigmask(SIG_BLOCK, &blocked, &before);
    const ProgramEnd end = run_program({"sh", "-c", "kill -TERM -$$; echo went on"}, "", limit_ms);
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
    CHECK(end.code == 128 + SIGTERM);
    CHECK(end.out.empty());
}

TEST_CASE("a program that does not exist is named") {
    CHECK_THROWS_WITH_AS(run_program({"pxpl5-nothing"}, "", limit_ms),
                         "pxpl5-nothing cannot start: No such file or directory", RequestError);
}
