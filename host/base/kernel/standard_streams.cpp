#include "host/base/kernel/standard_streams.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include "host/base/error.hpp"

namespace pxpl5::host {

namespace {

thread_local void (*redraw_line)() = nullptr;

/// True if standard output is a pipe whose reader has closed it.
bool has_no_reader() {
    pollfd output{STDOUT_FILENO, POLLOUT, 0};
    return poll(&output, 1, 0) == 1 && (output.revents & POLLERR) != 0;
}

}  // namespace

void open_missing_streams() {
    for (const int fd : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
        if (fcntl(fd, F_GETFD) < 0 && errno == EBADF) {
            // The lowest free number is this one, because those below are open.
            [[maybe_unused]] const int opened = open("/dev/null", O_RDWR);
        }
    }
}

std::string printable(std::string_view text) {
    std::string clean(text);
    for (std::size_t i = 0; i < clean.size(); ++i) {
        const auto c = static_cast<unsigned char>(clean[i]);
        // U+0080 to U+009F, the controls beyond ASCII, are C2 80 to C2 9F in UTF-8.
        const bool is_high =
            c >= 0x80 && c <= 0x9F && i > 0 && static_cast<unsigned char>(text[i - 1]) == 0xC2;
        if ((c < ' ' && c != '\t' && c != '\n') || c == 0x7F || is_high) {
            clean[i] = '?';
        }
    }
    return clean;
}

std::string_view line_clearer() {
    return isatty(STDERR_FILENO) != 0 ? "\r\x1b[K" : "";
}

void print_notice(std::string_view kind, std::string_view text) {
    const std::string line = fmt::format("{}{}: {}\n", line_clearer(), kind, printable(text));
    std::fwrite(line.data(), 1, line.size(), stderr);
    if (redraw_line != nullptr && isatty(STDERR_FILENO) != 0) {
        redraw_line();
    }
}

void redraw_after_notices(void (*redraw)()) {
    redraw_line = redraw;
}

int print_error(std::string_view text, int code) {
    print_notice("error", text);
    return code;
}

int finish_output(int code) {
    errno = 0;
    const bool is_written = std::fflush(stdout) == 0 && std::ferror(stdout) == 0;
    const int reason = errno;
    if (is_written || code != 0 || reason == EPIPE || has_no_reader()) {
        return code;
    }
    return print_error(fmt::format("standard output cannot be written: {}",
                                   std::strerror(reason == 0 ? EIO : reason)),
                       static_cast<int>(ExitCode::failed));
}

}  // namespace pxpl5::host
