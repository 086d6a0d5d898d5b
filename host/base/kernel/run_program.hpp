// Runs another program to its end, for a limited time.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace pxpl5::host {

/// The end of a program.
struct ProgramEnd {
    int code = 0;             ///< Exit code, or 128 + signal.
    bool is_in_time = true;   ///< False: it was killed, because it ran too long.
    std::string out, errors;  ///< Its output and error output, each of at most 64 KiB.
};

/// Runs `words` with `input` as its standard input, and waits for its end. Ctrl-C of the terminal
/// does not reach the program, and no signal is blocked in it. Writes past 64 KiB of output fail in
/// the program.
///
/// limit_ms  The program is killed after this time. The call then waits 5 s at most for the end.
/// stop_fd   Kills the program at once when it is readable; -1: none.
/// Throws RequestError (unavailable) that names the program and the reason if it cannot start or
/// cannot be watched.
ProgramEnd run_program(std::vector<std::string> words, std::string_view input, int limit_ms,
                       int stop_fd = -1);

}  // namespace pxpl5::host
