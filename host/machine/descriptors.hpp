// File descriptors: looks at the limit before a machine starts.
#pragma once

#include <cstddef>

namespace pxpl5::host {

/// Descriptors that the host or a node needs for a machine of `nodes` nodes, without those that are
/// open already.
std::size_t needed_descriptors(std::size_t nodes);

/// Raises the soft limit of this process and of its children, so that a machine of `nodes` nodes
/// fits. Throws RequestError (unavailable) with both numbers if the hard limit is too low.
void provide_descriptors(std::size_t nodes);

}  // namespace pxpl5::host
