// A confined process: a child that reports what it could do.
#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <exception>
#include <string>

namespace pxpl5::test {

struct Ending {
    int code = -1;    ///< The value that the action returned; -1 after a signal.
    int signal = 0;   ///< The signal that ended the child; 0 if none did.
    std::string log;  ///< Its standard error.
};

/// The code of a child whose action has thrown. No system call has this error.
inline constexpr int thrown = 255;

/// Runs `action` in a child and returns how the child ended.
template <typename Action>
Ending in_child(const Action& action) {
    std::array<int, 2> log{};
    [[maybe_unused]] const int made = pipe(log.data());
    const pid_t child = fork();
    if (child == 0) {
        dup2(log[1], STDERR_FILENO);
        try {
            _exit(action());
        } catch (const std::exception& error) {
            std::fprintf(stderr, "%s\n", error.what());
            _exit(thrown);
        }
    }
    close(log[1]);
    Ending ending;
    std::array<char, 256> block{};
    for (ssize_t got = 0; (got = read(log[0], block.data(), block.size())) > 0;) {
        ending.log.append(block.data(), static_cast<std::size_t>(got));
    }
    close(log[0]);
    int status = 0;
    waitpid(child, &status, 0);
    ending.code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    ending.signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
    return ending;
}

/// 0, or errno of a call that has returned `result`.
template <typename Result>
int error_of_call(Result result) {
    return result < 0 ? errno : 0;
}

}  // namespace pxpl5::test
