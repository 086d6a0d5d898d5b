// A word for a line that the user pastes into a shell.
#pragma once

#include <string>

namespace pxpl5::host::serve {

/// Returns `text` in single quotes, if a shell could read it in another way.
inline std::string shell_word(const std::string& text) {
    const char* const plain =
        "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789/._-+:,=@%";
    if (!text.empty() && text.find_first_not_of(plain) == std::string::npos) {
        return text;
    }
    std::string quoted = "'";
    for (const char c : text) {
        quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
    }
    return quoted + "'";
}

}  // namespace pxpl5::host::serve
