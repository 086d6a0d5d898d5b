// Plans of machines that the timing model runs, and no computer.
#pragma once

#include "host/machine/topology.hpp"

namespace pxpl5::host {

/// Limit of the GPs and of the Renderers of a modelled machine.
inline constexpr int max_modelled_nodes = 1024;

/// Does the work of load_topology() with a limit of max_modelled_nodes GPs and Renderers.
Topology load_modelled_topology(const std::string& name_or_path,
                                const std::vector<std::string>& overrides = {});

/// Does the work of apply_override() with the same limit, and refuses a count of 0, which means the
/// cores of this computer.
void apply_modelled_override(Topology& topology, std::string_view assignment);

}  // namespace pxpl5::host
