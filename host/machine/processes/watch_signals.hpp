// The signals that end a program, as events of a loop of libuv.
#pragma once

#include <uv.h>

#include <array>
#include <csignal>

namespace pxpl5::host {

using EndSignals = std::array<uv_signal_t, 3>;

/// Calls `take` at SIGINT, SIGTERM and SIGHUP. An ignored SIGHUP (nohup) stays ignored: the run
/// must outlive its terminal. Returns 0, or libuv's error.
inline int watch_end_signals(uv_loop_t& loop, EndSignals& signals, uv_signal_cb take) {
    constexpr std::array numbers = {SIGINT, SIGTERM, SIGHUP};
    int error = 0;
    for (std::size_t i = 0; i < numbers.size() && error == 0; ++i) {
        struct sigaction before {};
        sigaction(numbers[i], nullptr, &before);
        if (numbers[i] == SIGHUP && before.sa_handler == SIG_IGN) {
            continue;
        }
        error = uv_signal_init(&loop, &signals[i]);
        if (error == 0) {
            error = uv_signal_start(&signals[i], take, numbers[i]);
        }
    }
    return error;
}

}  // namespace pxpl5::host
