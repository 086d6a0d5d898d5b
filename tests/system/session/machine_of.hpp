// A small machine and a color for the tests of sessions.
#pragma once

#include "host/machine/topology.hpp"
#include "host/scene/scene.hpp"

namespace pxpl5::test {

inline constexpr host::Color gray{160, 160, 160};

inline host::Topology machine_of(int gps, int renderers, int gp_memory_mib = 64) {
    host::Topology topology;
    topology.gp.count = gps;
    topology.renderer.count = renderers;
    topology.frame_buffer.count = 1;
    topology.gp_memory_mib = gp_memory_mib;
    topology.seed = 11;
    return topology;
}

}  // namespace pxpl5::test
