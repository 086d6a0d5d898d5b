#include "host/machine/processes/kept_signals.hpp"

#include <fmt/format.h>

#include <utility>

#include "host/base/error.hpp"
#include "host/machine/port.hpp"
#include "host/machine/processes/watch_signals.hpp"

namespace pxpl5::host {

namespace {

KeptSignals* current_signals = nullptr;

[[noreturn]] void fail_to_keep(int error) {
    throw MachineError(
        static_cast<int>(ExitCode::unavailable),
        fmt::format("cannot watch signals during a restart: {}", uv_strerror(error)));
}

}  // namespace

/// libuv's handler of a signal stays as long as one loop watches the signal.
struct KeptSignals::Parts {
    uv_loop_t loop{};
    EndSignals signals{};
    std::deque<int> kept;

    void close() {
        uv_walk(
            &loop, [](uv_handle_t* handle, void*) { uv_close(handle, nullptr); }, nullptr);
        uv_run(&loop, UV_RUN_DEFAULT);
        uv_loop_close(&loop);
    }
};

KeptSignals::KeptSignals() : parts_(std::make_unique<Parts>()) {
    int error = uv_loop_init(&parts_->loop);
    if (error != 0) {
        fail_to_keep(error);
    }
    parts_->loop.data = parts_.get();
    error = watch_end_signals(parts_->loop, parts_->signals, [](uv_signal_t* handle, int number) {
        static_cast<Parts*>(handle->loop->data)->kept.push_back(number);
    });
    if (error != 0) {
        parts_->close();
        fail_to_keep(error);
    }
    current_signals = this;
}

KeptSignals::~KeptSignals() {
    current_signals = nullptr;
    parts_->close();
}

KeptSignals* KeptSignals::current() {
    return current_signals;
}

void KeptSignals::hand_over(const std::deque<int>& left) {
    uv_run(&parts_->loop, UV_RUN_NOWAIT);
    parts_->kept = left;
}

std::deque<int> KeptSignals::take() {
    uv_run(&parts_->loop, UV_RUN_NOWAIT);
    return std::exchange(parts_->kept, {});
}

}  // namespace pxpl5::host
