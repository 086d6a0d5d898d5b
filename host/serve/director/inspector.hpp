// Questions of the browser whose answers are bytes: slices of the volume, and a region's stream,
// step by step.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "host/session/session.hpp"

namespace pxpl5::host::serve {

/// As the page gets it, but for the id: see "Binary answers" in host/serve/README.md.
struct Answer {
    std::string json;  ///< One object.
    std::vector<std::byte> bytes;
};

/// Answers an `ask` message.
///
/// session  Its scene is drawn if the question is about a frame; what is found out of that frame is
///          kept there until the scene changes.
/// message  The whole message as it came, a JSON object; its id is not looked at.
/// Throws   RequestError: usage if the question is none, or none of this volume or picture, naming
///          what was given and what may be; else as Session. MachineError as Session.
Answer answer(Session& session, std::string_view message);

/// The answer as a binary message.
///
/// id       Of the question.
std::string answer_message(std::uint32_t id, const Answer& answer);

}  // namespace pxpl5::host::serve
