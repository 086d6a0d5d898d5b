#include "host/inspect/model/part_work.hpp"

#include "host/inspect/listing/run_stats.hpp"

namespace pxpl5::host::inspect {

namespace {

timing::PartWork work_of(const PartCounts& counts) {
    timing::PartWork part;
    part.region = counts.region;
    part.kind = counts.kind;
    part.surface = counts.surface;
    part.slab = counts.slab;
    part.primitives = counts.primitives;
    part.words = counts.is_segment() ? counts.total().words : 0;
    for (std::size_t i = 0; i < isa::op_count; ++i) {
        const OpCount& count = counts.ops[i];
        timing::ClassCounts& sum =
            part.classes[static_cast<std::size_t>(isa::class_of(static_cast<isa::Op>(i)))];
        sum.instructions += count.instructions;
        sum.cycles += count.cycles;
    }
    const auto cycles = [&](isa::Op op) { return counts.ops[static_cast<std::size_t>(op)].cycles; };
    part.port_cycles = cycles(isa::Op::pixels_to_fb);
    part.backing_cycles = cycles(isa::Op::bs_wait);
    return part;
}

}  // namespace

std::vector<timing::PartWork> part_work(const RecordedFrame& frame) {
    std::vector<timing::PartWork> parts;
    for (const auto& [number, region] : frame.regions) {
        for (const PartCounts& counts : count_region(frame, region)) {
            parts.push_back(work_of(counts));
        }
    }
    return parts;
}

}  // namespace pxpl5::host::inspect
