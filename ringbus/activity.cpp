#include "ringbus/activity.hpp"

#include <ctime>

namespace pxpl5::bus {

std::uint64_t processor_ns() {
    constexpr std::uint64_t ns_per_s = 1'000'000'000;
    timespec time{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return static_cast<std::uint64_t>(time.tv_sec) * ns_per_s +
           static_cast<std::uint64_t>(time.tv_nsec);
}

Payload activity_message(StageClock& clock, const Traffic& traffic, const NodeStatus& status,
                         std::size_t held_up) {
    schema::ActivityT activity;
    for (const StageClock::Stage& stage : clock.stages()) {
        activity.wall_ns += stage.ns;
        if (stage.name != stage::wait) {
            auto& entry = activity.stages.emplace_back(std::make_unique<schema::StageTimeT>());
            entry->name = stage.name;
            entry->ns = stage.ns;
            entry->count = stage.count;
        }
    }
    for (const SentCount& sum : traffic.sent) {
        activity.sent.emplace_back(sum.to, static_cast<std::uint16_t>(sum.kind), sum.channel,
                                   sum.messages, sum.bytes);
    }
    activity.cpu_ns = processor_ns();
    activity.received_messages = traffic.received_messages;
    activity.received_bytes = traffic.received_bytes;
    activity.memory_bytes = status.memory_bytes;
    activity.queue = static_cast<std::uint32_t>(status.queue);
    activity.held_up = static_cast<std::uint32_t>(held_up);
    activity.frames = status.frames;
    activity.refused_messages = traffic.refused_messages;
    return pack(activity);
}

}  // namespace pxpl5::bus
