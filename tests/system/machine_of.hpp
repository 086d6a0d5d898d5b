// A small machine for tests of sessions.
#pragma once

#include <cstdint>

#include "host/machine/topology.hpp"

namespace pxpl5::test {

inline host::Topology machine_of(int gps, int renderers, std::uint64_t seed = 11,
                                 int gp_memory_mib = 256) {
    host::Topology topology;
    topology.gp.count = gps;
    topology.renderer.count = renderers;
    topology.frame_buffer.count = 1;
    topology.gp_memory_mib = gp_memory_mib;
    topology.seed = seed;
    return topology;
}

}  // namespace pxpl5::test
