// Topology files: JSON, checked against topology.fbs.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "host/machine/topology.hpp"

namespace pxpl5::host {

/// Reads the plan without resolving counts of 0 or checking ranges.
/// Throws RequestError (usage) naming file, line and, for an unknown key, the nearest one.
Topology read_topology_file(std::string_view text, const std::string& file);

/// Section `timing` of host/topologies/paper-1993.json, compiled in: no file is read.
std::vector<TimingValue> paper_timing();

}  // namespace pxpl5::host
