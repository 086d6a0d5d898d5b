// Runs another program to its end, for a limited time.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace pxpl5::host {

/// The end of a program.
struct ProgramEnd {
    int code = 0;             ///< Exit code, or 128 + signal.
    bool is_in_time = true;   ///< False: it was killed, because it ran too long.
    std::string out, errors;  ///< Its output and error output, within their limits.
};

inline constexpr std::size_t max_output_bytes = 65'536;

/// Runs `words` with `input` as its standard input, and waits for its end. Ctrl-C of the terminal
/// does not reach the program, and no signal is blocked in it. Writes past the limit of output, and
/// past max_output_bytes of error output, fail in the program.
///
/// limit_ms   The program is killed after this time. The call then waits 5 s at most for the end.
/// stop_fd    Kills the program at once when it is readable; -1: none.
/// out_bytes  Limit of the output.
/// Throws RequestError (unavailable) that names the program and the reason if it cannot start or
/// cannot be watched.
ProgramEnd run_program(std::vector<std::string> words, std::string_view input, int limit_ms,
                       int stop_fd = -1, std::size_t out_bytes = max_output_bytes);

}  // namespace pxpl5::host
