// The section `timing` of a topology: its parameters' names, units and ranges, and its checks.
#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host/machine/topology.hpp"

namespace pxpl5::host {

/// A number of the timing model.
struct TimingRow {
    std::string_view name;  ///< "gp.edge_cycles"
    std::string_view unit;
    double least = 0, most = 0;
    bool whole = false;
    bool of_ring = false;  ///< Its value is in section `ring`.
};

/// All numbers, in the order of reports.
std::span<const TimingRow> timing_rows();

/// A choice of the timing model and its words.
struct TimingChoice {
    std::string_view name;
    std::span<const std::string_view> words;
};

// In the order of host::timing::Sharing and Assignment.
inline constexpr std::array<std::string_view, 2> share_words = {"even", "own"};
inline constexpr std::array<std::string_view, 4> assignment_words = {"first_free", "longest_first",
                                                                     "round_robin", "recorded"};
inline constexpr std::array timing_choices = {TimingChoice{"share", share_words},
                                              TimingChoice{"assignment", assignment_words}};

/// Every name of both, for messages.
std::vector<std::string_view> timing_names();

/// The entry called `name`; null if none exists.
const TimingValue* find_timing(const std::vector<TimingValue>& timing, std::string_view name);

/// Throws RequestError (usage) if a parameter is missing, unknown, given twice, not a number, out
/// of range or in another unit. The text begins with `where`.
void check_timing(const std::vector<TimingValue>& timing, const std::string& where);

/// Sets one value of `timing` from text. Returns false if section `timing` has no parameter `name`.
/// Throws RequestError (usage) if the text does not fit the parameter.
bool override_timing(std::vector<TimingValue>& timing, std::string_view name,
                     std::string_view text);

/// Marks the entry called `name`, if it exists, as set by the user.
void mark_overridden(std::vector<TimingValue>& timing, std::string_view name);

}  // namespace pxpl5::host
