// Errors that the person at the prompt caused or must know of, with the exit code they lead to.
#pragma once

#include <stdexcept>
#include <string>

namespace pxpl5::host {

/// Exit codes of the program (sysexits where one fits).
enum class ExitCode : int { ok = 0, failed = 1, usage = 64, bad_data = 65, unavailable = 69 };

/// A request that cannot be obeyed. `what` names what, where and both values.
struct RequestError : std::runtime_error {
    RequestError(ExitCode exit_code, const std::string& text)
        : std::runtime_error(text), code(exit_code) {}
    ExitCode code;
};

}  // namespace pxpl5::host
