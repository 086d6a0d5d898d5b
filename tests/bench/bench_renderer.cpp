// The fast executor on every vector target of this machine: triangles by size, single
// instructions, the beginning and the end of a region.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <cmath>
#include <string>
#include <vector>

#include "isa/contract/vector_target.hpp"
#include "renderer_firmware/fast/fast.hpp"
#include "renderer_firmware/igc/igc.hpp"
#include "renderer_firmware/igc/region_program.hpp"
#include "tests/renderer_firmware/triangles.hpp"

using namespace pxpl5;
using renderer::Igc;
using renderer::fast::Fast;
using Words = std::vector<std::uint32_t>;

namespace {

constexpr std::size_t triangle_count = 4000;
constexpr std::int32_t coefficients[] = {123456, -654321, 1 << 30, 7, -9, 11};

/// Equilateral triangles of `area_px` pixels, in rows over the region, each turned at random; half
/// of them lie behind what is there.
Words triangles(double area_px) {
    test::RandomPrograms random(9);
    const double radius = 16 * std::sqrt(area_px * 4 / (3 * std::sqrt(3.0)));
    const double step = radius * 0.9;
    constexpr double margin = 128, span = 1760, third = 2.0944;
    Words words;
    for (std::size_t i = 0; i < triangle_count; ++i) {
        const double along = step * static_cast<double>(i);
        const double x = margin + std::fmod(along, span);
        const double y = margin + std::fmod(std::floor(along / span) * step, span);
        const double turn = random.below(6283) / 1000.0;
        test::TrianglePlanes t = test::random_triangle(random, {0, 0}, 10);
        test::Corner corners[3];
        for (int k = 0; k < 3; ++k) {
            corners[k] = {static_cast<int>(std::lround(x + radius * std::cos(turn + k * third))),
                          static_cast<int>(std::lround(y + radius * std::sin(turn + k * third)))};
        }
        put_edges(corners[0], corners[1], corners[2], t);
        t.z[0] = t.z[1] = 1000;
        t.z[2] = static_cast<std::int32_t>(random.below(1U << 31));
        append(t, words);
    }
    return words;
}

/// Every pixel far, as the prologue leaves it.
const Words& clear() {
    static const Words words = {isa::encode({isa::Op::set_enabs, {}}),
                                isa::encode({isa::Op::const_into_mem, {0, 0, 32}}), 0xFFFFFF00};
    return words;
}

void triangle_stream(benchmark::State& state, VectorTarget target, double area_px) {
    Fast fast(target);
    Igc igc(fast);
    const Words words = triangles(area_px);
    for (auto _ : state) {
        state.PauseTiming();
        igc.run(clear());
        state.ResumeTiming();
        igc.run(words);
    }
    state.counters["triangles"] = benchmark::Counter(static_cast<double>(triangle_count),
                                                     benchmark::Counter::kIsIterationInvariantRate);
}

void instruction(benchmark::State& state, VectorTarget target, isa::Instruction in) {
    Fast fast(target);
    const auto words = static_cast<std::size_t>(isa::info(in.op).words);
    for (auto _ : state) {
        fast.execute({isa::Op::set_enabs, {}}, {});
        fast.execute(in, isa::Coefficients(coefficients, words));
    }
}

renderer::Shading shading() {
    renderer::Shading shading;
    shading.lights = {{{0.3F, 0.4F, 0.866F}, 0.8F}, {{-0.5F, 0.1F, 0.86F}, 0.3F}};
    shading.surfaces = {{230, 200, 180}};
    shading.specular_power = 20;
    return shading;
}

/// A surface with normals over the region's pixels where x < width: 128 all, 64 half, 0 none.
Words cover(int width) {
    const auto tree = [](std::uint32_t place, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        return Words{isa::encode({isa::Op::tree_into_mem, {place, 0, 10}}), a, b, c};
    };
    Words words = {
        isa::encode({isa::Op::set_enabs, {}}), isa::triangle::edge_word(16),
        static_cast<std::uint32_t>(-1),        0,
        static_cast<std::uint32_t>(width - 1), isa::encode({isa::Op::imm_into_mem, {0, 1, 8}})};
    for (const Words& part : {tree(32, 3, 5, 77), tree(42, 2, 7, 33)}) {
        words.insert(words.end(), part.begin(), part.end());
    }
    words.push_back(isa::encode({isa::Op::imm_into_mem, {52, 200, 10}}));
    return words;
}

void end_of_region(benchmark::State& state, VectorTarget target, int width) {
    Fast fast(target);
    Igc igc(fast);
    const renderer::RegionPrograms programs = renderer::region_programs(shading());
    const Words covered = cover(width);
    for (auto _ : state) {
        state.PauseTiming();
        igc.run(programs.prologue);
        igc.run(covered);
        state.ResumeTiming();
        igc.run(programs.end_of_region);
    }
}

void prologue(benchmark::State& state, VectorTarget target) {
    Fast fast(target);
    Igc igc(fast);
    const Words words = renderer::prologue(shading());
    for (auto _ : state) {
        igc.run(words);
    }
}

void reset(benchmark::State& state, VectorTarget target) {
    Fast fast(target);
    for (auto _ : state) {
        fast.reset();
    }
}

/// The rows that cost most in the end of region, and the readout.
struct Row {
    const char* name;
    isa::Instruction in;
};
constexpr Row rows[] = {
    {"TREEintoMEM:24", {isa::Op::tree_into_mem, {88, 8, 24}}},
    {"QUADintoMEM:24", {isa::Op::quad_into_mem, {88, 8, 24}}},
    {"MEMpluseqMEM:16", {isa::Op::mem_plus_mem, {96, 120, 16}}},
    {"MEMltMEM:16", {isa::Op::mem_lt_mem, {96, 96, 16}}},
    {"MULMEM:12", {isa::Op::mul_mem, {96, 140, 12}}},
    {"DIVMEM:20", {isa::Op::div_mem, {96, 140, 20}}},
    {"SQRTMEM:22", {isa::Op::sqrt_mem, {96, 0, 22}}},
    {"readout/PIXELSTOFB:24", {isa::Op::pixels_to_fb, {64, 0, 24}}},
};

}  // namespace

/// Which targets there are is known only when the program runs.
void register_renderer_benches() {
    for (const VectorTarget target : isa::available_targets()) {
        const std::string at = fmt::format("/{}", enum_name(target));
        for (const int area_px : {2, 8, 30, 100}) {
            benchmark::RegisterBenchmark(fmt::format("triangles/{}px{}", area_px, at).c_str(),
                                         triangle_stream, target, area_px);
        }
        for (const auto& [name, width] : {std::pair{"covered", 128}, {"half", 64}, {"empty", 0}}) {
            benchmark::RegisterBenchmark(fmt::format("end_of_region/{}{}", name, at).c_str(),
                                         end_of_region, target, width);
        }
        benchmark::RegisterBenchmark(("prologue" + at).c_str(), prologue, target);
        benchmark::RegisterBenchmark(("reset" + at).c_str(), reset, target);
        for (const Row& row : rows) {
            benchmark::RegisterBenchmark((row.name + at).c_str(), instruction, target, row.in);
        }
    }
}
