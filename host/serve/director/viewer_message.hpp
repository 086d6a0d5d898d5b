// Reads a viewer's JSON message.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace pxpl5::host::serve {

/// Exactly one of line, ask, cancels, panel and is_ping is set.
struct ViewerMessage {
    std::optional<std::uint32_t> id;
    std::optional<std::string> line;  ///< The command of "do".
    std::optional<std::string> ask;   ///< The kind of a question: "slice".
    std::optional<std::string> axis;  ///< The axis of a question about a slice.
    bool cancels = false;
    std::optional<bool> panel;
    bool is_ping = false;
};

/// Throws RequestError (usage) if the text is no message of host/serve/README.md.
ViewerMessage read_viewer_message(std::string_view text);

}  // namespace pxpl5::host::serve
