// Machines that go on after the loss of a computer.
#pragma once

#include <string>
#include <vector>

#include "host/machine/topology.hpp"

namespace pxpl5::host {

/// Leaves computers out of a plan. Nodes that were to run there may then run on any of the others.
///
/// plan    With an engine.
/// lost    Names. Others than those in `computers` are ignored, if the plan names its computers.
/// Returns the names that were left out: none if no computer would be left.
std::vector<std::string> leave_out(Topology& plan, const std::vector<std::string>& lost);

}  // namespace pxpl5::host
