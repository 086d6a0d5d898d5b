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

void run_own(Igc& igc, Words words, const char* name, isa::RunCounts& sum) {
    const Outcome outcome = igc.run(words);
    if (outcome.error) {
        throw std::logic_error(
            fmt::format("{}, word {}: {}", name, outcome.error->word, outcome.error->text));
    }
    add(sum, outcome.counts);
}

auto place(const Segment& s) {
    return std::tie(s.surface, s.slab);
}

SegmentFault fault(const Segment& s, std::string reason) {
    return {s.surface, s.slab, s.gp, std::move(reason)};
}

}  // namespace

RegionResult draw_region(isa::Executor& executor, const RegionFrame& frame,
                         std::vector<Segment> segments) {
    Igc igc(executor);
    std::sort(segments.begin(), segments.end(), [](const Segment& p, const Segment& q) {
        return std::tie(p.surface, p.slab, p.gp) < std::tie(q.surface, q.slab, q.gp);
    });
    RegionResult result;
    run_own(igc, frame.prologue, "prologue", result.counts);
    for (std::size_t i = 0; i < segments.size(); ++i) {
        const Segment& s = segments[i];
        if (i > 0 && place(segments[i - 1]) == place(s)) {
            result.faults.push_back(fault(
                s,
                fmt::format("GP {} has drawn this surface and slab already", segments[i - 1].gp)));
            continue;
        }
        const Outcome outcome = igc.run(s.words);
        add(result.counts, outcome.counts);
        if (outcome.error) {
            result.faults.push_back(
                fault(s, fmt::format("word {}: {}", outcome.error->word, outcome.error->text)));
        }
    }
    run_own(igc, frame.end_of_region, "end-of-region program", result.counts);
    return result;
}

}  // namespace pxpl5::renderer
