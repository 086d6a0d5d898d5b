#include "renderer_firmware/igc/region.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <tuple>

namespace pxpl5::renderer {

namespace {

void add(isa::RunCounts& sum, const isa::RunCounts& more) {
    sum.instructions += more.instructions;
    sum.cycles += more.cycles;
}

RegionPlan::Part own_part(RegionPlan::Kind kind, Words words, const char* name) {
    if (const std::optional<isa::ProgramError> error = Igc::check(words)) {
        throw std::logic_error(fmt::format("{}, word {}: {}", name, error->word, error->text));
    }
    RegionPlan::Part part;
    part.kind = kind;
    part.segment.words = words;
    return part;
}

auto place(const Segment& s) {
    return std::tie(s.surface, s.slab);
}

SegmentFault fault(const Segment& s, std::string reason) {
    return {s.surface, s.slab, s.gp, std::move(reason)};
}

}  // namespace

RegionPlan plan_region(const RegionFrame& frame, std::vector<Segment> segments) {
    std::sort(segments.begin(), segments.end(), [](const Segment& p, const Segment& q) {
        return std::tie(p.surface, p.slab, p.gp) < std::tie(q.surface, q.slab, q.gp);
    });
    RegionPlan plan;
    using Kind = RegionPlan::Kind;
    plan.parts.push_back(own_part(Kind::prologue, frame.prologue, "prologue"));
    for (std::size_t i = 0; i < segments.size(); ++i) {
        const Segment& s = segments[i];
        if (i > 0 && place(segments[i - 1]) == place(s)) {
            plan.faults.push_back(fault(
                s,
                fmt::format("GP {} has drawn this surface and slab already", segments[i - 1].gp)));
        } else if (const std::optional<isa::ProgramError> error = Igc::check(s.words)) {
            plan.faults.push_back(fault(s, fmt::format("word {}: {}", error->word, error->text)));
        } else {
            plan.parts.push_back({Kind::segment, s});
        }
    }
    plan.parts.push_back(
        own_part(Kind::end_of_region, frame.end_of_region, "end-of-region program"));
    return plan;
}

RegionResult draw_region(isa::Executor& executor, const RegionFrame& frame,
                         std::vector<Segment> segments) {
    RegionPlan plan = plan_region(frame, std::move(segments));
    RegionResult result{{}, std::move(plan.faults)};
    Igc igc(executor);
    for (const RegionPlan::Part& part : plan.parts) {
        const Outcome outcome = igc.run_checked(part.segment.words);
        add(result.counts, outcome.counts);
        if (outcome.error) {
            result.faults.push_back(
                fault(part.segment,
                      fmt::format("word {}: {}", outcome.error->word, outcome.error->text)));
        }
    }
    return result;
}

}  // namespace pxpl5::renderer
