// Calls that may block for long, such as a name service, with a limit.
#pragma once

#include <chrono>
#include <cstdint>
#include <future>
#include <optional>
#include <thread>
#include <type_traits>
#include <utility>

namespace pxpl5::host {

/// Returns the result of `act`, or nothing if it takes longer than `limit_ms`. `act` then goes on
/// in a thread of its own, so it must own all that it uses. Throws what `act` throws in time.
template <class Act>
std::optional<std::invoke_result_t<Act>> answer_within(std::int64_t limit_ms, Act act) {
    std::packaged_task<std::invoke_result_t<Act>()> task(std::move(act));
    std::future<std::invoke_result_t<Act>> answer = task.get_future();
    std::thread(std::move(task)).detach();
    if (answer.wait_for(std::chrono::milliseconds(limit_ms)) != std::future_status::ready) {
        return std::nullopt;
    }
    return answer.get();
}

}  // namespace pxpl5::host
