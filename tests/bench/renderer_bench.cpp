// How long the fast executor takes: triangles by size, single instructions, the end of a region.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "isa/sequencer.hpp"
#include "renderer_firmware/fast/fast.hpp"
#include "renderer_firmware/igc/igc.hpp"
#include "renderer_firmware/igc/region_program.hpp"
#include "tests/renderer_firmware/triangles.hpp"

using namespace pxpl5;
using renderer::fast::Fast;

namespace {

constexpr std::size_t triangle_count = 4000;

/// Median time of one call, in ns.
template <typename Action>
double median_ns(int rounds, const Action& action) {
    std::vector<double> times;
    for (int i = 0; i < rounds; ++i) {
        const auto begin = std::chrono::steady_clock::now();
        action();
        const auto end = std::chrono::steady_clock::now();
        times.push_back(std::chrono::duration<double, std::nano>(end - begin).count());
    }
    std::nth_element(times.begin(), times.begin() + rounds / 2, times.end());
    return times[static_cast<std::size_t>(rounds) / 2];
}

/// Equilateral triangles of `area_px` pixels, in rows over the region, each turned at random.
std::vector<std::uint32_t> triangles(double area_px) {
    test::RandomPrograms random(9);
    const double radius = 16 * std::sqrt(area_px * 4 / (3 * std::sqrt(3.0)));
    std::vector<std::uint32_t> words;
    for (std::size_t i = 0; i < triangle_count; ++i) {
        const double step = radius * 0.9;
        const double along = step * static_cast<double>(i);
        const double x = 128 + std::fmod(along, 1760);
        const double y = 128 + std::fmod(std::floor(along / 1760) * step, 1760);
        const double turn = random.below(6283) / 1000.0;
        test::TrianglePlanes t = test::random_triangle(random, {0, 0}, 10);
        test::Corner corners[3];
        for (int k = 0; k < 3; ++k) {
            corners[k] = {static_cast<int>(std::lround(x + radius * std::cos(turn + k * 2.0944))),
                          static_cast<int>(std::lround(y + radius * std::sin(turn + k * 2.0944)))};
        }
        put_edges(corners[0], corners[1], corners[2], t);
        // Sixteen times 2^24 in steps: half of the triangles lie behind what is there.
        t.z[0] = t.z[1] = 1000;
        t.z[2] = static_cast<std::int32_t>(random.below(1U << 31));
        append(t, words);
    }
    return words;
}

void bench_triangles(Fast& fast) {
    for (const double area : {2.0, 8.0, 30.0, 100.0}) {
        const std::vector<std::uint32_t> words = triangles(area);
        isa::Controller controller;
        const std::vector<std::uint32_t> clear = {
            isa::encode({isa::Op::set_enabs, {}}),
            isa::encode({isa::Op::const_into_mem, {0, 0, 32}}), 0xFFFFFF00};
        std::vector<double> times;
        for (int i = 0; i < 15; ++i) {
            isa::run(clear, fast, controller);
            times.push_back(median_ns(1, [&] { renderer::Igc(fast).run(words); }));
        }
        std::nth_element(times.begin(), times.begin() + 7, times.end());
        fmt::print("  triangle of {:3} px          {:8.1f} ns\n", area, times[7] / triangle_count);
    }
}

void bench_instructions(Fast& fast) {
    struct Row {
        const char* name;
        isa::Instruction in;
    };
    const Row rows[] = {
        {"TREEintoMEM :24 >>8", {isa::Op::tree_into_mem, {88, 8, 24}}},
        {"TREEintoMEM :40 >>8", {isa::Op::tree_into_mem, {88, 8, 40}}},
        {"QUADintoMEM :24 >>8", {isa::Op::quad_into_mem, {88, 8, 24}}},
        {"MEMpluseqMEM :16", {isa::Op::mem_plus_mem, {96, 120, 16}}},
        {"MEMltMEM :16", {isa::Op::mem_lt_mem, {96, 96, 16}}},
        {"MULMEM :12", {isa::Op::mul_mem, {96, 140, 12}}},
        {"MULMEM :24", {isa::Op::mul_mem, {96, 150, 24}}},
        {"DIVMEM :20", {isa::Op::div_mem, {96, 140, 20}}},
        {"DIVMEM :32", {isa::Op::div_mem, {96, 140, 32}}},
        {"SQRTMEM :22", {isa::Op::sqrt_mem, {96, 0, 22}}},
        {"PIXELSTOFB :24", {isa::Op::pixels_to_fb, {64, 0, 24}}},
    };
    const std::int32_t k[] = {123456, -654321, 1 << 30, 7, -9, 11};
    for (const Row& row : rows) {
        const auto words = static_cast<std::size_t>(isa::info(row.in.op).words);
        const double ns = median_ns(101, [&] {
            fast.execute({isa::Op::set_enabs, {}}, {});
            fast.execute(row.in, isa::Coefficients(k, words));
        });
        fmt::print("  {:22}     {:8.2f} us\n", row.name, ns / 1000);
    }
}

void bench_region(Fast& fast) {
    renderer::Shading shading;
    shading.lights = {{{0.3F, 0.4F, 0.866F}, 0.8F}, {{-0.5F, 0.1F, 0.86F}, 0.3F}};
    shading.surfaces = {{230, 200, 180}};
    shading.specular_power = 20;
    const renderer::RegionPrograms programs = renderer::region_programs(shading);
    renderer::Igc igc(fast);
    const std::vector<std::uint32_t> cover = {isa::encode({isa::Op::set_enabs, {}}),
                                              isa::encode({isa::Op::imm_into_mem, {0, 1, 8}}),
                                              isa::encode({isa::Op::tree_into_mem, {32, 0, 10}}),
                                              3,
                                              5,
                                              77,
                                              isa::encode({isa::Op::tree_into_mem, {42, 0, 10}}),
                                              2,
                                              7,
                                              33,
                                              isa::encode({isa::Op::imm_into_mem, {52, 200, 10}})};
    std::vector<double> times;
    std::uint64_t instructions = 0;
    for (int i = 0; i < 51; ++i) {
        igc.run(programs.prologue);
        igc.run(cover);
        times.push_back(median_ns(
            1, [&] { instructions = igc.run(programs.end_of_region).counts.instructions; }));
    }
    std::nth_element(times.begin(), times.begin() + 25, times.end());
    fmt::print("  reset of the executor      {:8.2f} us\n",
               median_ns(51, [&] { fast.reset(); }) / 1000);
    fmt::print("  prologue                   {:8.2f} us\n",
               median_ns(51, [&] { igc.run(programs.prologue); }) / 1000);
    fmt::print("  end of region, covered     {:8.2f} us, {} instructions\n", times[25] / 1000,
               instructions);
}

}  // namespace

int main() {
    for (const renderer::fast::Target target : isa::available_targets()) {
        fmt::print("{}\n", isa::target_name(target));
        Fast fast(target);
        bench_triangles(fast);
        bench_instructions(fast);
        bench_region(fast);
    }
}
