#include "host/timing/counts/machine.hpp"

#include <algorithm>
#include <array>

#include "host/machine/timing_section.hpp"
#include "host/machine/topology_file.hpp"

namespace pxpl5::host::timing {

namespace {

constexpr std::array rows = {
#define PXPL5_TIMING(field, name, unit, least, most, whole) \
    Parameter{name, unit, &Machine::field, least, most, whole},
#define PXPL5_TIMING_RING(field, name, unit, least, most) \
    Parameter{name, unit, &Machine::ring_##field, least, most, true},
#include "host/machine/timing_parameters.def"
};

/// The choice made of `words`; check_timing has found it among them.
template <typename Enum>
Enum chosen(const std::vector<TimingValue>& timing, std::string_view name,
            std::span<const std::string_view> words) {
    const auto word = std::find(words.begin(), words.end(), find_timing(timing, name)->word);
    return static_cast<Enum>(word - words.begin());
}

void set_ring(Machine& machine, const RingSettings& ring) {
#define PXPL5_TIMING_RING(field, name, unit, least, most) machine.ring_##field = ring.field;
#include "host/machine/timing_parameters.def"
}

}  // namespace

std::span<const Parameter> parameters() {
    return rows;
}

Machine machine_of(const Topology& topology) {
    const std::vector<TimingValue> timing =
        topology.timing.empty() ? paper_timing() : topology.timing;
    check_timing(timing, topology.name);
    Machine machine;
    machine.gps = static_cast<std::uint32_t>(topology.gp.count);
    machine.renderers = static_cast<std::uint32_t>(topology.renderer.count);
    machine.frame_buffers = static_cast<std::uint32_t>(topology.frame_buffer.count);
    machine.share = chosen<Sharing>(timing, "share", share_words);
    machine.assignment = chosen<Assignment>(timing, "assignment", assignment_words);
    for (const Parameter& parameter : rows) {
        machine.*parameter.value = find_timing(timing, parameter.name)->value.value_or(0);
    }
    set_ring(machine, topology.ring);
    return machine;
}

}  // namespace pxpl5::host::timing
