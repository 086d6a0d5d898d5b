// Measures the work after a GP's drawing: verifying and decoding its message, a Renderer's frame,
// assembling.
#include <benchmark/benchmark.h>

#include <optional>

#include "renderer_firmware/node_frame.hpp"
#include "tests/bench/parts.hpp"

using namespace pxpl5;
using bench::Held;
using bus::Body;

namespace {

/// A frame of the head's skin, in the messages of one GP and one Renderer.
struct Frame {
    explicit Frame(host::Size size) : parts("phantom:head", size) {
        parts.draw(1);
        begin.emplace(parts.gp_wire.first(Body::BeginFrame));
        programs.emplace(parts.gp_wire.first(Body::RegionPrograms));
        render(1);
        pixels.emplace(parts.renderer_wire.first(Body::RegionPixels));
    }
    void render(std::uint32_t frame) {
        begin->set_frame(frame);
        programs->set_frame(frame);
        parts.renderer_wire.sent.clear();
        parts.renderer.receive(begin->message(bench::renderer_id), parts.renderer_wire);
        parts.renderer.receive(programs->message(bench::renderer_id), parts.renderer_wire);
        bench::Parts::work(parts.renderer, parts.renderer_wire);
    }

    bench::Parts parts;
    std::optional<Held> begin, programs, pixels;
};

host::Size size_of(const benchmark::State& state) {
    return {static_cast<int>(state.range(0)), static_cast<int>(state.range(1))};
}

void name_sizes(benchmark::internal::Benchmark* bench) {
    bench->ArgNames({"width", "height"})
        ->Args({512, 512})
        ->Args({1280, 1024})
        ->Unit(benchmark::kMillisecond);
}

void verify_programs(benchmark::State& state) {
    const Frame frame(size_of(state));
    for (auto _ : state) {
        benchmark::DoNotOptimize(frame.programs->message(bench::renderer_id));
    }
    state.counters["bytes"] = static_cast<double>(frame.programs->size_bytes());
}

void decode_programs(benchmark::State& state) {
    const Frame frame(size_of(state));
    renderer::FrameMessages messages;
    messages.begin = frame.begin->message(bench::renderer_id);
    messages.programs.emplace(0, frame.programs->message(bench::renderer_id));
    for (auto _ : state) {
        benchmark::DoNotOptimize(renderer::plan_frame(messages, 0));
    }
}

/// RegionPrograms to RegionPixels: prologue, triangles, end of region, readout of every region.
void renderer_frame(benchmark::State& state) {
    Frame frame(size_of(state));
    std::uint32_t number = 1;
    for (auto _ : state) {
        frame.render(++number);
    }
}

/// RegionPixels to FrameDone.
void assemble(benchmark::State& state) {
    Frame frame(size_of(state));
    bench::Parts& parts = frame.parts;
    std::uint32_t number = 0;
    for (auto _ : state) {
        frame.begin->set_frame(++number);
        frame.pixels->set_frame(number);
        parts.frame_buffer_wire.sent.clear();
        parts.frame_buffer.receive(frame.begin->message(bench::renderer_id),
                                   parts.frame_buffer_wire);
        parts.frame_buffer.receive(frame.pixels->message(bench::renderer_id),
                                   parts.frame_buffer_wire);
        bench::Parts::work(parts.frame_buffer, parts.frame_buffer_wire);
    }
    benchmark::DoNotOptimize(parts.frame_buffer_wire.first(Body::FrameDone));
}

BENCHMARK(verify_programs)->Apply(name_sizes);
BENCHMARK(decode_programs)->Apply(name_sizes);
BENCHMARK(renderer_frame)->Apply(name_sizes);
BENCHMARK(assemble)->Apply(name_sizes);

}  // namespace
