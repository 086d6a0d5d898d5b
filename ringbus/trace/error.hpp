// The error of trace files.
#pragma once

#include <stdexcept>

namespace pxpl5::bus::trace {

/// Thrown for a file that cannot be written or read; `what` names file, place and reason.
struct TraceError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

}  // namespace pxpl5::bus::trace
