// Sources of command lines: text, and a person at the terminal.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>

namespace pxpl5::host {

/// Gives the next command line, or nothing at the end.
using LineSource = std::function<std::optional<std::string>()>;

/// Returns when the descriptor is readable. It may throw to end the wait.
using WaitReadable = std::function<void(int fd)>;

/// Waits until `fd` is readable (with `wait_readable` if it is set), then reads.
///
/// Returns   the number of bytes read; 0 at the end of the input and for a closed descriptor.
/// Throws    RequestError (bad_data) naming `name` if reading fails.
std::size_t read_some(int fd, const WaitReadable& wait_readable, std::span<char> bytes,
                      const std::string& name);

/// Commands of `text`, which are separated by ';' or newlines outside quotes and comments.
LineSource lines_of_text(const std::string& text);
/// Lines that a person types at the terminal, with history and editing.
LineSource lines_of_prompt(WaitReadable wait_readable = {});

}  // namespace pxpl5::host
