// Standard input, output and error of the program.
#pragma once

#include <string>
#include <string_view>

namespace pxpl5::host {

/// Opens /dev/null for each of the three that is closed. Otherwise the first files and sockets of
/// the program would take their numbers, and texts would be written into them.
void open_missing_streams();

/// Returns `text` with '?' for control characters except tab and newline. Names and contents of
/// files may hold sequences that change a terminal.
std::string printable(std::string_view text);

/// Characters that clear the terminal's current line, for example a progress bar or an echoed ^C.
/// Empty if standard error is no terminal.
std::string_view line_clearer();

/// Prints "KIND: TEXT" on a line of its own on standard error, printable. kind  For example "note".
void print_notice(std::string_view kind, std::string_view text);

/// Sets what draws the cleared line again after a notice of the same thread: a prompt, while a
/// person types. nullptr: nothing.
void redraw_after_notices(void (*redraw)());

/// Prints "error: TEXT" as print_notice() does. Returns `code`.
int print_error(std::string_view text, int code);

/// Flushes standard output. Returns `code`, but 1 after an error that says so if `code` is 0 and
/// the output is not written. A reader that has gone (| head) is no error.
int finish_output(int code);

}  // namespace pxpl5::host
