// Measures the modelling of a frame of 1993 with 270,000 triangles, the largest of the paper.
#include <benchmark/benchmark.h>

#include "host/timing/simulate.hpp"

using namespace pxpl5;
using namespace pxpl5::host;

namespace {

constexpr std::uint32_t slabs = 108, regions = 80;
constexpr std::uint64_t triangles_per_segment = 31;  ///< 267,840 in all.

/// 1280 x 1024; in every region something of every slab.
timing::FrameWork heavy_frame() {
    timing::FrameWork frame;
    frame.width = 1280;
    frame.height = 1024;
    for (std::uint32_t slab = 0; slab < slabs; ++slab) {
        frame.drawn.push_back({0, slab, triangles_per_segment * regions});
    }
    for (std::uint32_t region = 0; region < regions; ++region) {
        for (std::uint32_t slab = 0; slab < slabs; ++slab) {
            timing::PartWork part;
            part.region = region;
            part.slab = slab;
            part.primitives = triangles_per_segment;
            part.words = triangles_per_segment * 34;
            part.classes[1] = {triangles_per_segment * 10, triangles_per_segment * 232};
            frame.parts.push_back(part);
        }
        timing::PartWork end;
        end.region = region;
        end.kind = PartKind::end_of_region;
        end.port_cycles = 16'400;
        end.classes[5] = {70, 16'400 + 10'000};
        frame.parts.push_back(end);
    }
    return frame;
}

/// Frames shown over and over until the rate is settled: 20 of them.
void modelled_rate(benchmark::State& state) {
    const timing::Machine machine = timing::machine_of(load_topology("paper-1993"));
    const timing::FrameWork frame = heavy_frame();
    for (auto _ : state) {
        benchmark::DoNotOptimize(timing::frame_rate(machine, frame));
    }
}
BENCHMARK(modelled_rate)->Unit(benchmark::kMillisecond);

}  // namespace
