#include <doctest/doctest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <new>
#include <string>
#include <vector>

#include "host/io/limits.hpp"

using namespace pxpl5::host::io;

namespace {

/// How a child that runs `action` ends.
template <typename F>
int wait_status(F&& action) {
    const pid_t child = fork();
    if (child == 0) {
        action();
        _exit(0);
    }
    int status = 0;
    waitpid(child, &status, 0);
    return status;
}

}  // namespace

TEST_SUITE("host/io/limits") {
    TEST_CASE("the limits are taken out of the command line, the rest stays in order") {
        std::vector<std::string> arguments = {"pxpl5-io",     "--cpu-s=7", "--bind",   "ipc://x",
                                              "--memory-mib", "512",       "--version"};
        const Limits limits = take_limits(arguments);
        CHECK(limits.cpu_s == 7);
        CHECK(limits.memory_mib == 512);
        CHECK(arguments == std::vector<std::string>{"pxpl5-io", "--bind", "ipc://x", "--version"});
    }

    TEST_CASE("a limit that is no number or has no value is refused by name") {
        std::vector<std::string> word = {"pxpl5-io", "--cpu-s", "7s"};
        CHECK_THROWS_WITH(take_limits(word), "--cpu-s is '7s', must be a whole number");
        std::vector<std::string> end = {"pxpl5-io", "--memory-mib"};
        CHECK_THROWS_WITH(take_limits(end), "--memory-mib needs a value");
    }

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
    TEST_CASE("an allocation beyond the memory limit fails as bad_alloc") {
        const int status = wait_status([] {
            limit_memory({512, 0});
            try {
                const std::vector<char> large(std::size_t{1} << 30);
                _exit(large[7]);
            } catch (const std::bad_alloc&) {
                _exit(42);
            }
        });
        CHECK(WIFEXITED(status));
        CHECK(WEXITSTATUS(status) == 42);
    }
#endif

    TEST_CASE("a request that never ends is ended by the processor limit") {
        const int status = wait_status([] {
            limit_next_request({0, 1});
            for (volatile unsigned spin = 0;;) {
                spin = spin + 1;
            }
        });
        CHECK(WIFSIGNALED(status));
        CHECK(WTERMSIG(status) == SIGXCPU);
    }
}
