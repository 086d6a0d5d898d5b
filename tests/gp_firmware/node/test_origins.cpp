// Where primitives come from: what each side table says, computed again from the voxels.
#include <doctest/doctest.h>

#include <cmath>
#include <functional>
#include <glm/gtc/matrix_transform.hpp>
#include <iostream>
#include <random>

#include "gp_firmware/geometry/clip.hpp"
#include "gp_firmware/render/draw_slab.hpp"
#include "gp_firmware/render/triangle_program.hpp"
#include "tests/gp_firmware/test_volume.hpp"
#include "tests/random_seed.hpp"

using namespace pxpl5;
using namespace pxpl5::test;

namespace {

/// Voxels that are noise, so that all cases occur, ambiguous ones too.
Volume noise(Size size, std::mt19937& random) {
    std::uniform_int_distribution<int> value(0, 255);
    return make_volume(size, Scalar::uint8, [&](int, int, int) { return value(random); });
}

/// From a random side, with a clip plane through the middle; near enough that the frustum clips.
gp::Camera random_camera(Size size, std::mt19937& random) {
    std::uniform_real_distribution<double> turn(-3, 3);
    gp::Camera camera;
    camera.width_px = 300;
    camera.height_px = 200;
    glm::dmat4 m = glm::translate(glm::dmat4(1.0), glm::dvec3(0, 0, -12));
    m = glm::rotate(m, turn(random), glm::normalize(glm::dvec3(1, turn(random), 2)));
    camera.voxel_to_eye =
        glm::translate(m, -0.5 * glm::dvec3(size.nx - 1, size.ny - 1, size.nz - 1));
    camera.projection = glm::perspective(1.0, 1.5, 10.0, 30.0);
    camera.clip_planes.emplace_back(1, turn(random), turn(random), -2);
    return camera;
}

struct Scene {
    Volume volume;
    double isovalue = 0;
    CaseRule rule{};
    gp::Camera camera;
    gp::RegionGrid grid;
    gp::RegionPrograms programs;
};

/// Extracts and draws all slabs with their origins.
Scene drawn(Size size, CaseRule rule, std::mt19937& random) {
    Scene s{noise(size, random), 127.5, rule, random_camera(size, random), {}, {}};
    s.grid = gp::region_grid(s.camera.width_px, s.camera.height_px, 0);
    s.programs.begin_frame(static_cast<std::size_t>(s.grid.count()), true);
    const Gp gp(s.volume, {0, 1});
    const gp::Projection projection = gp::prepare(s.camera);
    gp::DrawScratch scratch;
    gp::SlabMesh mesh;  // Of all slabs in turn, as a GP's is of all revisions.
    for (int slab = 0; slab < s.volume.shape.slab_count(); ++slab) {
        gp::extract_slab(gp.store, slab, s.isovalue, gp::case_table(rule), mesh, true);
        REQUIRE(mesh.origins.size() * 3 == mesh.indices.size());
        s.programs.begin_slab(0, static_cast<std::uint32_t>(slab));
        gp::draw_slab(mesh, projection, s.grid, {0, false}, scratch, s.programs);
    }
    s.programs.end_frame();
    return s;
}

double voxel(const Volume& volume, int x, int y, int z) {
    return static_cast<double>(static_cast<std::uint8_t>(
        volume.values[static_cast<std::size_t>((z * volume.shape.ny + y) * volume.shape.nx + x)]));
}

/// The one cell by itself: a volume of 4x4x4 voxels about it would have other gradients, so only
/// positions are computed: each corner's by linear interpolation, in the mesh's precision.
std::vector<gp::Vertex> triangle_again(const Scene& s, const gp::Origin& o, int k) {
    std::uint8_t inside = 0;
    std::array<double, 8> value{};
    for (int c = 0; c < 8; ++c) {
        value[static_cast<std::size_t>(c)] =
            voxel(s.volume, o.i + (c & 1), o.j + (c >> 1 & 1), k + (c >> 2));
        inside |= static_cast<std::uint8_t>(
            (value[static_cast<std::size_t>(c)] >= s.isovalue ? 1 : 0) << c);
    }
    REQUIRE(inside == o.inside);
    const gp::CaseTable& table = gp::case_table(s.rule);
    const gp::CaseEntry& entry = table.entry(o.inside, o.joined);
    REQUIRE(o.triangle < entry.triangle_count);
    const auto on_edge = [&](int edge) {
        const auto ends = gp::edge_corners(edge);
        const double v0 = value[static_cast<std::size_t>(ends[0])];
        const double v1 = value[static_cast<std::size_t>(ends[1])];
        glm::dvec3 p(o.i + (ends[0] & 1), o.j + (ends[0] >> 1 & 1), k + (ends[0] >> 2));
        p[edge / 4] += (s.isovalue - v0) / (v1 - v0);
        return glm::vec3(p);
    };
    std::vector<gp::Vertex> corners;
    for (std::size_t n = 0; n < 3; ++n) {
        const std::uint8_t edge = table.corners_of(entry)[std::size_t{o.triangle} * 3 + n];
        glm::dvec3 sum(0);
        if (edge == gp::center_corner) {
            for (const std::uint8_t ring : table.ring_of(entry)) {
                sum += glm::dvec3(on_edge(ring)) / static_cast<double>(entry.ring_size);
            }
        }
        const glm::vec3 p = edge == gp::center_corner ? glm::vec3(sum) : on_edge(edge);
        corners.push_back({p, {0, 0, 32767}, 0});
    }
    return corners;
}

/// Edges and z plane of a triangle's piece, as its words in the region have them; nothing if the
/// words are not those of `words`.
bool has_set_up_of(const Scene& s, const std::vector<gp::Vertex>& corners, const gp::Origin& o,
                   std::size_t region, const std::uint32_t* words) {
    const gp::Projection projection = gp::prepare(s.camera);
    const std::vector<gp::ScreenVertex> screen = gp::transformed(corners, projection);
    std::vector<gp::ScreenVertex> polygon;
    gp::clip_triangle({&corners[0], &corners[1], &corners[2]}, {&screen[0], &screen[1], &screen[2]},
                      projection, polygon);
    if (polygon.size() < std::size_t{o.piece} + 3U) {
        return false;
    }
    const gp::ScreenVertex& a = polygon[0];
    gp::ScreenVertex b = polygon[o.piece + 1U], c = polygon[o.piece + 2U];
    std::int64_t det = gp::determinant(a, b, c);
    if (det < 0) {
        std::swap(b, c);
        det = -det;
    }
    const auto edges = gp::edges_of(a, b, c);
    const auto planes = gp::planes_of(a, b, c, det);
    const int x0 = static_cast<int>(region) % s.grid.columns * 128;
    const int y0 = static_cast<int>(region) / s.grid.columns * 128;
    bool same = words[isa::triangle::at_z_test + 1] == planes.a[0] &&
                words[isa::triangle::at_z_test + 2] == planes.b[0];
    for (std::size_t k = 0; k < 3; ++k) {
        const auto edge = gp::region_edge(edges[k], x0, y0);
        const std::uint32_t* at = words + isa::triangle::at_edge[k];
        same = same && edge && at[0] == edge->word && at[1] == edge->a && at[2] == edge->b &&
               at[3] == edge->c;
    }
    return same;
}

/// Checks every primitive; returns how many there were, and how many came from clipping.
std::pair<int, int> check_all(const Scene& s) {
    int primitives = 0, pieces = 0, wrong = 0;
    for (std::size_t region = 0; region < s.programs.regions().size(); ++region) {
        const gp::RegionProgram& program = s.programs.regions()[region];
        std::vector<std::uint32_t> words(program.word_count());
        gp::write_words(s.programs, region, s.grid, words.data());
        REQUIRE(program.origins.size() * isa::triangle::word_count == words.size());
        for (const gp::Segment& segment : program.segments) {
            for (std::size_t at = segment.first_word; at < segment.first_word + segment.word_count;
                 at += isa::triangle::word_count) {
                const gp::Origin& o = program.origins.values()[at / isa::triangle::word_count];
                const auto corners = triangle_again(s, o, static_cast<int>(segment.slab));
                wrong += has_set_up_of(s, corners, o, region, &words[at]) ? 0 : 1;
                ++primitives;
                pieces += o.piece > 0 ? 1 : 0;
            }
        }
    }
    CHECK(wrong == 0);
    return {primitives, pieces};
}

}  // namespace

TEST_SUITE("gp/origins") {
    TEST_CASE("every emitted primitive names the cell and triangle that it comes from") {
        const unsigned seed = seed_or(1U);
        MESSAGE("seed ", seed);
        std::mt19937 random(seed);
        int primitives = 0, pieces = 0;
        for (const auto rule :
             {CaseRule::watertight, CaseRule::lorensen1987, CaseRule::asymptotic}) {
            for (int n = 0; n < 4; ++n) {
                // Rows of more than one mask word, too.
                const Scene s = drawn(n == 3 ? Size{70, 4, 4} : Size{7, 6, 5}, rule, random);
                const auto [all, clipped] = check_all(s);
                primitives += all;
                pieces += clipped;
            }
        }
        CHECK(primitives > 2000);
        CHECK(pieces > 20);
    }
    TEST_CASE("words and meshes are the same with origins and without") {
        std::mt19937 random(seed_or<std::uint64_t>(2));
        const Volume volume = noise({9, 9, 9}, random);
        const Gp gp(volume, {0, 1});
        gp::SlabMesh with, without;
        for (int slab = 0; slab < volume.shape.slab_count(); ++slab) {
            const auto& table = gp::case_table(CaseRule::watertight);
            gp::extract_slab(gp.store, slab, 99.5, table, with, true);
            gp::extract_slab(gp.store, slab, 99.5, table, without);
            CHECK(with.indices == without.indices);
            CHECK(with.keys == without.keys);
            CHECK(without.origins.empty());
            CHECK(with.origins.size() == with.indices.size() / 3);
        }
        // Asked for and then not: what an earlier surface left is gone.
        gp::extract_slab(gp.store, 0, 99.5, gp::case_table(CaseRule::watertight), with);
        CHECK(with.origins.empty());
    }
}
