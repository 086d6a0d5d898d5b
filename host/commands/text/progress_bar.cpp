#include "host/commands/text/progress_bar.hpp"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <string>

#include "host/base/kernel/standard_streams.hpp"
#include "host/base/stopwatch.hpp"

namespace pxpl5::host {

namespace {

constexpr double silent_ms = 300;
constexpr int bar_width = 40;

}  // namespace

ProgressBar::ProgressBar(Session& session) : session_(session), started_ns_(now_ns()) {
    draws_ = !session_.load_settings.progress && isatty(STDERR_FILENO) != 0;
    if (draws_) {
        session_.load_settings.progress = [this](const LoadProgress& now) {
            show(now.phase == LoadProgress::Phase::reading ? "reading" : "distributing", now.done,
                 now.total);
        };
        session_.tell_pictures = [this](int done, int total) { show("working", done, total); };
    }
}

ProgressBar::~ProgressBar() {
    if (draws_) {
        session_.load_settings.progress = nullptr;
        session_.tell_pictures = nullptr;
    }
    if (drawn_) {
        fmt::print(stderr, "{}", line_clearer());
    }
}

void ProgressBar::show(const char* phase, int done, int total) {
    if (ms_since(started_ns_) < silent_ms) {
        return;
    }
    const int filled = total == 0 ? 0
                                  : static_cast<int>(std::min<std::int64_t>(
                                        bar_width, std::int64_t{bar_width} * done / total));
    fmt::print(stderr, "{}{:<12} [{:<{}}] {} of {}  (Ctrl-C cancels)", line_clearer(), phase,
               std::string(static_cast<std::size_t>(filled), '='), bar_width, done, total);
    drawn_ = true;
}

}  // namespace pxpl5::host
