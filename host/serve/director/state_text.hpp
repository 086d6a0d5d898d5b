// Writes a session's state for the page.
#pragma once

#include <cstdint>
#include <string>

#include "host/session/session.hpp"

namespace pxpl5::host::serve {

/// Values of the state that the session does not have.
struct StateExtras {
    std::uint32_t revision = 0;
    std::string busy;  ///< The work under way; empty for none.
    std::string topology;
    bool is_recording = false;
};

/// {"state": {..}} in one line; host/serve/README.md describes the fields.
std::string state_text(const Session& session, const StateExtras& extras);

}  // namespace pxpl5::host::serve
