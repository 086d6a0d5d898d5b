// Which node runs on which computer.
#pragma once

#include <string>
#include <vector>

#include "host/machine/roster.hpp"
#include "host/machine/topology.hpp"

namespace pxpl5::host {

/// The number of the host's own computer.
inline constexpr int own_computer = 0;

/// The computer of each node of `roster`: own_computer, or 1 for computers[0] and so on.
///
/// The host and the frame buffers run on the host's own computer, so that a picture crosses the
/// network once. Renderers are placed before GPs, on as few computers as possible, because their
/// pixels go to one place. A node is on the computer that the topology names for it, if any. If
/// there are more nodes than slots, the others are spread in proportion to the slots.
///
/// computers  With slots above 0.
/// Throws     RequestError (usage) if the topology names a computer that is not there.
std::vector<int> place_nodes(const Roster& roster, const Topology& topology,
                             const std::vector<ComputerSlots>& computers);

}  // namespace pxpl5::host
