// Writes a session's state for the page.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "host/session/session.hpp"

namespace pxpl5::host::serve {

/// The end of the program that is known before it comes.
struct EndNotice {
    std::string at, why;  ///< See EndState in page_schema.fbs.
    std::string saved;    ///< File of the session; empty if it is not saved.
    std::string open;     ///< The command that opens the file.
    std::string problem;  ///< Why the session cannot be saved.
};

/// "This session ends at 2026-11-24T05:00:00Z: job 12 reaches its time limit."
std::string sentence_of(const EndNotice& notice);

/// Values of the state that the session does not have.
struct StateExtras {
    std::uint32_t revision = 0;
    std::string busy;  ///< The work under way; empty for none.
    std::string topology;
    bool is_recording = false;
    std::optional<EndNotice> end = std::nullopt;
};

/// {"state": {..}} in one line; host/serve/README.md describes the fields.
std::string state_text(const Session& session, const StateExtras& extras);

}  // namespace pxpl5::host::serve
