// Errors of requests, and the exit codes of the program.
#pragma once

#include <stdexcept>
#include <string>

namespace pxpl5::host {

/// Exit codes of the program (sysexits where one fits).
enum class ExitCode : int {
    ok = 0,
    failed = 1,
    warning = 3,  ///< A command gave a warning under --strict.
    usage = 64,
    bad_data = 65,
    unavailable = 69
};

/// A request that failed. The text names the thing, the place and both values.
struct RequestError : std::runtime_error {
    RequestError(ExitCode exit_code, const std::string& text)
        : std::runtime_error(text), code(exit_code) {}
    ExitCode code;
};

/// A request that the io process has refused, or during which it has died.
struct IoFailure : RequestError {
    using RequestError::RequestError;
};

/// Returns the text of an error with one full stop at its end, for a text that goes on behind it.
/// Most errors have none. Errors that end in a remedy, and those of libraries, may have one.
inline std::string with_stop(std::string text) {
    if (!text.ends_with('.')) {
        text += '.';
    }
    return text;
}

}  // namespace pxpl5::host
