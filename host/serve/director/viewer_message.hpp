// Reads a viewer's JSON message.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "host/base/error.hpp"
#include "host/serve/director/headset_eyes.hpp"

namespace pxpl5::host::serve {

/// Exactly one of line, ask, cancels, panel, is_ping and is_of_headset is set.
struct ViewerMessage {
    std::optional<std::uint32_t> id;
    std::optional<std::string> line;  ///< The command of "do".
    std::optional<std::string> ask;   ///< The kind of a question: "slice".
    std::optional<std::string> axis;  ///< The axis of a question about a slice.
    bool is_ahead = false;            ///< The slice is not wanted yet.
    bool cancels = false;
    std::optional<bool> panel;
    bool is_ping = false;
    bool is_of_headset = false;       ///< "eyes" is there.
    std::optional<HeadsetEyes> eyes;  ///< Nothing if "eyes" is null: the headset is taken off.
};

/// The fault of a message, and the number to answer to, if the message has one.
struct MessageError : RequestError {
    MessageError(const RequestError& error, std::optional<std::uint32_t> its_id)
        : RequestError(error), id(its_id) {}
    std::optional<std::uint32_t> id;
};

/// Throws MessageError (usage) if the text is no message of host/serve/README.md.
ViewerMessage read_viewer_message(std::string_view text);

}  // namespace pxpl5::host::serve
