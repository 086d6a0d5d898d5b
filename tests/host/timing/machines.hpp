// Machines and counts for tests of the model, with round figures of their own.
#pragma once

#include <algorithm>

#include "host/timing/simulate.hpp"

namespace pxpl5::host::timing::testing {

/// A machine whose every message, cycle and hop is a round number of nanoseconds: a word takes 50
/// ns on a channel, a hop 50 ns, a cycle of a GP or Renderer 25 ns, a word 1 us on the host's link.
inline Machine round_machine() {
    Machine machine;
    machine.host_link_mb_s = 4;
    machine.host_message_us = 100;
    machine.gp_clock_mhz = 40;
    machine.gp_message_us = 10;
    machine.gp_edge_cycles = 4;
    machine.gp_build_triangle_cycles = 400;
    machine.gp_gradient_cycles = 8;
    machine.gp_list_triangle_words = 20;
    machine.gp_draw_primitive_cycles = 1000;
    machine.gp_emit_word_cycles = 10;
    machine.master_region_cycles = 40;
    machine.ring_channels = 8;
    machine.ring_channel_mb_s = 80;
    machine.ring_hop_ns = 50;
    machine.ring_header_words = 2;
    machine.ring_message_words = 1024;
    machine.ring_fifo_words = 4096;
    machine.renderer_clock_mhz = 40;
    machine.frame_buffer_ports = 2;
    machine.frame_buffer_refresh_hz = 50;
    machine.frames_in_flight = 1;
    return machine;
}

inline const UnitUse& use_of(const std::vector<UnitUse>& use, Unit unit) {
    return *std::ranges::find(use, unit, &UnitUse::unit);
}

inline PartWork part(std::uint32_t region, PartKind kind, std::uint64_t cycles) {
    PartWork work;
    work.region = region;
    work.kind = kind;
    work.classes[0] = {1, cycles};
    return work;
}

/// One primitive of the tests' frames.
inline constexpr std::uint64_t primitive_words = 34, primitive_cycles = 232;

inline PartWork segment(std::uint32_t region, std::uint32_t slab, std::uint64_t primitives) {
    PartWork work = part(region, PartKind::segment, primitives * primitive_cycles);
    work.slab = slab;
    work.primitives = primitives;
    work.words = primitives * primitive_words;
    return work;
}

/// A frame of one surface; each slab's primitives lie in one region each, slab s in region s mod
/// regions.
inline FrameWork frame_of(std::uint32_t width, std::uint32_t height, std::uint32_t slabs,
                          std::uint64_t primitives_per_slab) {
    FrameWork frame;
    frame.width = width;
    frame.height = height;
    const auto regions = static_cast<std::uint32_t>(frame.regions());
    for (std::uint32_t slab = 0; slab < slabs; ++slab) {
        frame.drawn.push_back({0, slab, primitives_per_slab});
    }
    for (std::uint32_t region = 0; region < regions; ++region) {
        frame.parts.push_back(part(region, PartKind::prologue, 200));
        for (std::uint32_t slab = region; slab < slabs; slab += regions) {
            frame.parts.push_back(segment(region, slab, primitives_per_slab));
        }
        PartWork end = part(region, PartKind::end_of_region, 16'000 + 4'000);
        end.port_cycles = 16'000;
        frame.parts.push_back(end);
        frame.assignment.push_back(0);
    }
    return frame;
}

}  // namespace pxpl5::host::timing::testing
