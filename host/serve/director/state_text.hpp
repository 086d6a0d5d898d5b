// A session's state as the page gets it.
#pragma once

#include <cstdint>
#include <string>

#include "host/session/session.hpp"

namespace pxpl5::host::serve {

/// What the session does not know of itself.
struct StateExtras {
    std::uint32_t revision = 0;
    std::string busy;  ///< What is being done; empty for nothing.
    std::string topology;
    bool is_recording = false;
};

/// {"state": {..}} as host/serve/README.md says, in one line.
std::string state_text(const Session& session, const StateExtras& extras);

}  // namespace pxpl5::host::serve
