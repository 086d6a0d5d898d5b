// Topology files: a text that is read gives a plan in its ranges, and the plan's own text gives the
// same plan.
#include "host/machine/topology.hpp"

#include "host/base/error.hpp"
#include "host/machine/timing_section.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace pxpl5::fuzz {

namespace {

using host::Topology;

void in(const char* name, int value, int low, int high) {
    require(value >= low && value <= high, std::string(name) + " is " + std::to_string(value));
}

void check_ranges(const Topology& plan) {
    in("gp.count", plan.gp.count, 1, max_nodes_per_role);
    in("renderer.count", plan.renderer.count, 1, max_nodes_per_role);
    in("frame_buffer.count", plan.frame_buffer.count, 1, 2);
    in("gp.memory_mib", plan.gp_memory_mib, 1, 1 << 20);
    in("gp.slabs_per_set", plan.slabs_per_set, 0, max_volume_voxels);
    require(plan.ring.channels >= 1 && plan.ring.channel_mb_s >= 1 && plan.ring.hop_ns >= 0,
            "the ring");
    in("heartbeat.interval_ms", plan.heartbeat.interval_ms, 10, 60'000);
    in("heartbeat.misses", plan.heartbeat.misses, 0, 1000);
    in("heartbeat.stuck_s", plan.heartbeat.stuck_s, 0, 86'400);
    require(plan.ring.transport <= Transport::MAX && plan.record <= Recording::MAX &&
                plan.vector_target <= VectorTarget::MAX,
            "the plan's choices");
    for (const host::TimingRow& row : host::timing_rows()) {
        const host::TimingValue* value = host::find_timing(plan.timing, row.name);
        require(value != nullptr, "a parameter that is missing: " + std::string(row.name));
        require(!value->value || (*value->value >= row.least && *value->value <= row.most),
                "the range of " + std::string(row.name));
    }
}

}  // namespace

/// Input: the text of a file, then a 0 byte and overrides, each with a 0 byte behind it.
bool accepts(Input input) {
    Bytes bytes(input);
    const std::string text = bytes.text_before(0);
    std::vector<std::string> overrides;
    while (!bytes.empty()) {
        overrides.push_back(bytes.text_before(0));
    }
    try {
        const Topology plan = host::parse_topology(text, "machine.json", overrides);
        check_ranges(plan);
        const std::string own = host::resolved_json(plan);
        require(host::resolved_json(host::parse_topology(own, "machine.json")) == own,
                "the plan's own text gives another plan: " + own);
        return true;
    } catch (const host::RequestError& error) {
        require(error.code == host::ExitCode::usage && *error.what() != 0,
                "a topology's error: " + std::string(error.what()));
        return false;
    }
}

}  // namespace pxpl5::fuzz
