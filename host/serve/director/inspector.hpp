// Answers the browser's questions with bytes: slices of the volume and the steps of a region.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "host/session/session.hpp"

namespace pxpl5::host::serve {

/// A binary answer without its id: see "Binary answers" in host/serve/README.md.
struct Answer {
    std::string json;  ///< One object.
    std::vector<std::byte> bytes;
};

/// Answers an `ask` message.
///
/// session  Draws the scene if the question is about a frame. Keeps the frame's recording until the
///          scene changes.
/// message  The whole message, a JSON object. The id is ignored.
/// Throws   RequestError (usage) for an invalid question; the text has the value and the allowed
///          values. Throws RequestError and MachineError as Session does.
Answer answer(Session& session, std::string_view message);

/// The answer as a binary message.
///
/// id       The question's id.
std::string answer_message(std::uint32_t id, const Answer& answer);

}  // namespace pxpl5::host::serve
