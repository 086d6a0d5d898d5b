// What a viewer says, taken from its JSON.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace pxpl5::host::serve {

/// One of line, ask, cancel, panel is there.
struct ViewerMessage {
    std::optional<std::uint32_t> id;
    std::optional<std::string> line;  ///< Of "do".
    std::optional<std::string> ask;   ///< What is asked: "slice".
    std::optional<std::string> axis;  ///< Of an ask about one.
    bool cancels = false;
    std::optional<bool> panel;
};

/// Throws RequestError (usage) with a sentence if it is no message of host/serve/README.md.
ViewerMessage read_viewer_message(std::string_view text);

}  // namespace pxpl5::host::serve
