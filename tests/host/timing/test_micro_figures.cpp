// The machine's published rates, from the model with the parameters of paper-1993 and streams that
// the GPs' own code writes.
#include <doctest/doctest.h>

#include <glm/gtc/matrix_transform.hpp>
#include <vector>

#include "gp_firmware/render/draw_scene.hpp"
#include "host/timing/simulate.hpp"
#include "isa/program.hpp"
#include "tests/gp_firmware/render/support.hpp"

namespace pxpl5::host::timing {

namespace {

/// The Renderer's counts for one primitive.
struct Cost {
    std::uint64_t words = 0, cycles = 0;
};

Cost cost_of(const gp::RegionPrograms& programs, const gp::RegionGrid& grid) {
    const std::vector<std::uint32_t> words = test::words_of(programs, 0, grid);
    const isa::CheckResult checked = isa::check(words);
    REQUIRE(checked.ok());
    REQUIRE(!checked.facts.has_flow);
    return {words.size(), checked.facts.cycles};
}

/// A right-angled triangle whose short sides have that many pixels, in the middle of a region.
Cost triangle(int side_px) {
    const int first = (128 - side_px) / 2 * 16;
    test::Random random(1);
    const test::Triangle corners = {test::vertex_at(first, first, random),
                                    test::vertex_at(first + side_px * 16, first, random),
                                    test::vertex_at(first, first + side_px * 16, random)};
    const gp::RegionGrid grid = gp::region_grid(128, 128, 0);
    gp::RegionPrograms programs;
    programs.begin_frame(1);
    programs.begin_slab(0, 0);
    REQUIRE(gp::draw_screen_triangle(corners[0], corners[1], corners[2], grid, {}, programs) == 1);
    programs.end_frame();
    return cost_of(programs, grid);
}

/// A sphere of some 20 pixels' radius in the middle of a region.
Cost sphere() {
    gp::Camera camera;
    camera.width_px = camera.height_px = 128;
    camera.voxel_to_eye = glm::translate(glm::dmat4(1.0), glm::dvec3(0, 0, -40));
    camera.projection = glm::perspective(0.5, 1.0, 20.0, 60.0);
    const gp::RegionGrid grid = gp::region_grid(128, 128, 0);
    gp::RegionPrograms programs;
    programs.begin_frame(1);
    programs.begin_slab(0, 0);
    gp::SlabMesh mesh;
    mesh.spheres.push_back({{0, 0, 0}, 1.5F});
    REQUIRE(gp::draw_spheres(mesh, gp::prepare(camera), grid, {}, programs).triangles_out == 1);
    programs.end_frame();
    return cost_of(programs, grid);
}

/// A frame with this number of primitives in each of 80 regions; nothing else costs a Renderer
/// anything.
FrameWork frame_of(std::uint64_t primitives_per_region, const Cost& cost) {
    FrameWork frame;
    frame.width = 1280;
    frame.height = 1024;
    frame.drawn = {{0, 0, 0}};
    for (std::uint32_t region = 0; region < frame.regions(); ++region) {
        PartWork part;
        part.region = region;
        part.primitives = primitives_per_region;
        part.words = primitives_per_region * cost.words;
        part.classes[1] = {primitives_per_region, primitives_per_region * cost.cycles};
        frame.parts.push_back(part);
        frame.drawn[0].primitives += primitives_per_region;
    }
    return frame;
}

Machine machine_of(std::uint32_t gps, std::uint32_t renderers) {
    Machine machine = timing::machine_of(load_topology("paper-1993"));
    machine.gps = gps;
    machine.renderers = renderers;
    return machine;
}

/// Primitives a second that a machine draws, shared out evenly over GPs and regions.
double rate_of(const Machine& machine, const Cost& cost, Unit busiest) {
    constexpr std::uint64_t per_region = 720;
    const FrameWork frame = frame_of(per_region, cost);
    const Rate rate = frame_rate(machine, frame);
    CHECK(busiest_of(rate.use).unit == busiest);
    return rate.frames_per_s * static_cast<double>(per_region * frame.regions());
}

/// Sixteen Renderers, and all else quick enough for them. A word takes 50 ns of a channel, so that
/// eight bring 4.7 million triangles a second.
Machine plenty() {
    Machine machine = machine_of(64, 16);
    machine.gp_draw_primitive_cycles = 0;
    machine.gp_message_us = 0;
    machine.frame_buffer_ports = 8;
    return machine;
}

constexpr double renderer_hz = 40e6;

}  // namespace

// A Renderer's target is about 150,000 Phong triangles/s. [M, medium confidence]
TEST_CASE("one Renderer draws about 150,000 Phong triangles a second") {
    const Cost phong = triangle(8);
    CHECK(phong.words == isa::triangle::word_count);
    const double drawn = rate_of(machine_of(36, 1), phong, Unit::renderer);
    // Ours may be better: the stream's cost comes from bits, which were 16 for edges, 24 for z and
    // 12 for normals as proposed for the machine, 216..270 cycles. [P]
    CHECK(phong.cycles >= 216);
    CHECK(phong.cycles <= 270);
    CHECK(drawn >= 150'000 * 0.9);
    CHECK(drawn <= 150'000 * 1.2);
    // No faster than its array; slower by the readout of 80 regions at most, which it overlaps.
    CHECK(drawn <= renderer_hz / static_cast<double>(phong.cycles));
    CHECK(drawn >= 0.95 * renderer_hz / static_cast<double>(phong.cycles));
}

// 2 million Phong triangles/s and more. [S: Yoo & Chen, section IV]
TEST_CASE("sixteen Renderers draw more than 2 million Phong triangles a second") {
    CHECK(rate_of(plenty(), triangle(8), Unit::renderer) >= 2e6);
}

// About 30,000 Phong triangles/s per GP, and 22,500..26,200 in the paper's results, where 36 GPs
// also wait. [M, medium confidence; D from S] The parameter is fitted to these, so that a wider
// band would say nothing: from the lowest to the figure remembered.
TEST_CASE("one GP sends about 30,000 Phong triangles a second") {
    const double sent = rate_of(machine_of(1, 16), triangle(8), Unit::gp);
    CHECK(sent >= 22'500);
    CHECK(sent <= 33'000);
}

// 700,000 spheres/s, April 1991; the configuration is not stated. [F: J. Leech] Sixteen Renderers
// at that rate have 914 cycles a sphere; ours, exact in depth and normal, takes a root in every
// pixel, and six times as many. So this figure is not met: about a sixth of it is.
TEST_CASE("sixteen Renderers draw our exact spheres at a sixth of the published rate") {
    const Cost exact = sphere();
    const double drawn = rate_of(plenty(), exact, Unit::renderer);
    CHECK(drawn <= 16 * renderer_hz / static_cast<double>(exact.cycles));
    CHECK(drawn >= 0.95 * 16 * renderer_hz / static_cast<double>(exact.cycles));
    CHECK(drawn >= 700'000.0 / 7);
    CHECK(drawn <= 700'000.0 / 5);
}

// Every pixel of a region works at once, so that a triangle's size inside it does not matter.
// [F: SIGGRAPH '89, one instruction for all pixel processors]
TEST_CASE("a triangle costs the same whether it covers 2 or 70 pixels of a region") {
    const Cost small = triangle(2), large = triangle(12);
    CHECK(small.words == large.words);
    CHECK(small.cycles == large.cycles);
    const Machine machine = machine_of(36, 1);
    CHECK(rate_of(machine, small, Unit::renderer) == rate_of(machine, large, Unit::renderer));
    // Beyond, an edge's values over the region need 24 bits instead of 16: 8 cycles for each of
    // three at most, a tenth.
    const Cost whole = triangle(126);
    CHECK(whole.words == small.words);
    CHECK(whole.cycles <= small.cycles + 3 * 8);
}

}  // namespace pxpl5::host::timing
