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

/// Begins `act` in a thread of its own, which may outlive the answer's owner, so `act` must own all
/// that it uses. The destructor of the answer does not wait.
template <class Act>
std::future<std::invoke_result_t<Act>> begin_answer(Act act) {
    std::packaged_task<std::invoke_result_t<Act>()> task(std::move(act));
    std::future<std::invoke_result_t<Act>> answer = task.get_future();
    std::thread(std::move(task)).detach();
    return answer;
}

/// Returns the result of `act`, or nothing if it takes longer than `limit_ms`. `act` then goes on
/// as for begin_answer(). Throws what `act` throws in time.
template <class Act>
std::optional<std::invoke_result_t<Act>> answer_within(std::int64_t limit_ms, Act act) {
    std::future<std::invoke_result_t<Act>> answer = begin_answer(std::move(act));
    if (answer.wait_for(std::chrono::milliseconds(limit_ms)) != std::future_status::ready) {
        return std::nullopt;
    }
    return answer.get();
}

}  // namespace pxpl5::host
