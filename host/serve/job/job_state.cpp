#include "host/serve/job/job_state.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

namespace pxpl5::host::serve {

namespace {

constexpr std::string_view blanks = " \n";

struct Meaning {
    std::string_view reason, text;
};

// Slurm's other reasons say by themselves what is missing.
constexpr std::array<Meaning, 7> meanings{
    {{"Resources", "the computers that it needs are in use"},
     {"Priority", "other jobs are before it"},
     {"PartitionTimeLimit", "its time limit is longer than the partition allows"},
     {"PartitionNodeLimit", "it asks for more computers than the partition allows"},
     {"ReqNodeNotAvail", "a computer that it names cannot be used"},
     {"JobHeldUser", "you hold it: scontrol release"},
     {"BeginTime", "its begin time has not come"}}};

/// The value of " Key=Value"; empty if it is missing or one of Slurm's words for nothing.
std::string value_of(const std::string& printed, std::string_view key, std::string_view ends) {
    for (std::size_t at = 0; (at = printed.find(key, at)) != std::string::npos; ++at) {
        if (at > 0 && blanks.find(printed[at - 1]) == std::string_view::npos) {
            continue;
        }
        const std::size_t from = at + key.size();
        const std::string value = printed.substr(from, printed.find_first_of(ends, from) - from);
        return value == "(null)" || value == "Unknown" || value == "None" ? "" : value;
    }
    return "";
}

JobState::Phase phase_of(std::string_view name) {
    constexpr std::array<std::string_view, 8> waiting{
        "PENDING",      "CONFIGURING",  "REQUEUED",      "REQUEUE_FED",
        "REQUEUE_HOLD", "SPECIAL_EXIT", "RESV_DEL_HOLD", "POWER_UP_NODE"};
    constexpr std::array<std::string_view, 11> ended{
        "",          "BOOT_FAIL",     "CANCELLED", "COMPLETED", "DEADLINE", "FAILED",
        "NODE_FAIL", "OUT_OF_MEMORY", "PREEMPTED", "REVOKED",   "TIMEOUT"};
    // The others, such as RUNNING, STOPPED or COMPLETING, and those of later versions, may go on.
    return std::ranges::find(waiting, name) != waiting.end() ? JobState::Phase::waits
           : std::ranges::find(ended, name) != ended.end()   ? JobState::Phase::has_ended
                                                             : JobState::Phase::runs;
}

}  // namespace

JobState parse_job_state(const std::string& printed) {
    JobState state;
    state.name = value_of(printed, "JobState=", blanks);
    state.phase = phase_of(state.name);
    state.reason = value_of(printed, "Reason=", blanks);
    state.start = value_of(printed, "StartTime=", blanks);
    state.computers = value_of(printed, "NodeList=", blanks);
    state.output = value_of(printed, "StdOut=", "\n");  // A path may have blanks.
    return state;
}

std::string sentence_of(const JobState& state) {
    if (state.phase == JobState::Phase::has_ended) {
        return fmt::format("has ended: {}", state.name.empty() ? "unknown to Slurm" : state.name);
    }
    if (state.phase == JobState::Phase::runs) {
        return fmt::format("{} on {}",
                           state.name == "RUNNING"      ? "runs"
                           : state.name == "COMPLETING" ? "ends"
                                                        : "is " + state.name,
                           state.computers);
    }
    std::string text = state.name == "PENDING" ? "waits" : fmt::format("waits, {}", state.name);
    if (!state.reason.empty()) {
        const auto* known = std::ranges::find_if(
            meanings, [&](const Meaning& each) { return state.reason.starts_with(each.reason); });
        text += ": " + state.reason;
        text += known == meanings.end() ? "" : fmt::format(" ({})", known->text);
    }
    return text + (state.start.empty() ? "" : ". Expected start: " + state.start);
}

}  // namespace pxpl5::host::serve
