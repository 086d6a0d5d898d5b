// Builds a node's answer to AskActivity.
#pragma once

#include <cstddef>
#include <cstdint>

#include "ringbus/node.hpp"
#include "ringbus/stage_clock.hpp"
#include "ringbus/traffic.hpp"

namespace pxpl5::bus {

/// Names of stages are short words.
inline constexpr std::size_t max_stage_name = 32;

/// Returns the processor time of all threads of this process, in ns.
std::uint64_t processor_ns();

/// clock    The node's clock. The answer has all of its stages but stage::wait.
/// held_up  Messages that wait at the node for credit.
Payload activity_message(StageClock& clock, const Traffic& traffic, const NodeStatus& status,
                         std::size_t held_up);

}  // namespace pxpl5::bus
