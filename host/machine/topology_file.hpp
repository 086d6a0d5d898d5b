// Topology files: JSON, checked against topology.fbs.
#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host/base/error.hpp"
#include "host/machine/topology.hpp"

namespace pxpl5::host {

/// Reads the plan without resolving counts of 0 or checking ranges.
/// Throws RequestError (usage) naming file, line and, for an unknown key, the nearest one.
Topology read_topology_file(std::string_view text, const std::string& file);

/// Section `timing` of host/topologies/paper-1993.json, compiled in: no file is read.
std::vector<TimingValue> paper_timing();

/// The value whose name is `text`. Throws RequestError (usage) naming `key` and all values.
template <typename Enum>
Enum value_named(std::string_view key, std::string_view text) {
    if (const std::optional<Enum> value = enum_named<Enum>(text)) {
        return *value;
    }
    constexpr auto& names = enum_names<Enum>;
    throw RequestError(ExitCode::usage,
                       fmt::format("{} is '{}', must be {} or {}", key, text,
                                   fmt::join(names.begin(), names.end() - 1, ", "), names.back()));
}

}  // namespace pxpl5::host
