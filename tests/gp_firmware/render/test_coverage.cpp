// Coverage: what the edges of a triangle program let through, against exact arithmetic.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "tests/gp_firmware/render/support.hpp"

using namespace pxpl5;
using namespace pxpl5::test;

namespace {

/// The words of `t` in the region at (x0, y0); nothing if it was found not to touch it.
std::optional<std::array<std::uint32_t, shape::word_count>> words_of(const Triangle& t, int x0,
                                                                     int y0) {
    const std::int64_t det = gp::determinant(t[0], t[1], t[2]);
    const auto edges = gp::edges_of(t[0], t[1], t[2]);
    std::array<gp::RegionEdge, 3> here;
    for (std::size_t k = 0; k < 3; ++k) {
        const auto edge = gp::region_edge(edges[k], x0, y0);
        if (!edge) {
            return std::nullopt;
        }
        here[k] = *edge;
    }
    std::array<std::uint32_t, shape::word_count> words{};
    gp::write_triangle(here, gp::planes_of(t[0], t[1], t[2], det), x0, y0, shape::surface_word(1),
                       words.data());
    return words;
}

/// Compares all pixels of the region at (x0, y0).
void check_region(const Triangle& t, int x0, int y0) {
    const auto words = words_of(t, x0, y0);
    int wrong = 0;
    for (int y = 0; y < 128; ++y) {
        for (int x = 0; x < 128; ++x) {
            const bool passes = words && triangle_passes(words->data(), x, y);
            wrong += passes != covers(t, x0 + x, y0 + y) ? 1 : 0;
        }
    }
    INFO("triangle (", t[0].x, ",", t[0].y, ") (", t[1].x, ",", t[1].y, ") (", t[2].x, ",", t[2].y,
         ") region at ", x0, ",", y0, " seed ", seed());
    CHECK(wrong == 0);
}

/// `count` random triangles with corners within `spread` of a point of the picture, on a lattice of
/// `step`, all in 1/16 px.
void check_random(int count, int spread, int step, std::uint64_t stream) {
    Random random(stream);
    constexpr int limit = gp::guard_px * 16;
    for (int i = 0; i < count; ++i) {
        const int x0 = random.integer(0, 3) * 128, y0 = random.integer(0, 3) * 128;
        const int cx = (x0 + random.integer(0, 127)) * 16, cy = (y0 + random.integer(0, 127)) * 16;
        Triangle t;
        for (ScreenVertex& v : t) {
            const int x = cx + random.integer(-spread, spread) / step * step + 8;
            const int y = cy + random.integer(-spread, spread) / step * step + 8;
            v = vertex_at(std::clamp(x, -limit, limit), std::clamp(y, -limit, limit), random);
        }
        if (const auto positive = oriented(t)) {
            check_region(*positive, x0, y0);
        }
    }
}

}  // namespace

TEST_SUITE("gp/coverage") {
    TEST_CASE("small triangles cover exactly what the top-left rule says") {
        check_random(600, 40, 1, 1);
    }
    TEST_CASE("triangles of the size of a region cover exactly what the top-left rule says") {
        check_random(300, 3000, 1, 2);
    }
    TEST_CASE("triangles as large as the guard band cover exactly what the top-left rule says") {
        check_random(300, 16 * gp::guard_px, 1, 3);
    }
    TEST_CASE("vertices and edges exactly on pixel centers follow the top-left rule") {
        check_random(400, 100, 16, 4);
        check_random(400, 60, 8, 5);
        check_random(200, 16 * gp::guard_px, 16, 6);
    }
    TEST_CASE("slivers cover exactly what the top-left rule says") {
        Random random(7);
        for (int i = 0; i < 400; ++i) {
            const int length = 1 << random.integer(3, 18);
            const int x = random.integer(0, 2047), y = random.integer(0, 2047);
            const int dx = random.integer(-length, length), dy = random.integer(-length, length);
            const auto clamp = [](int v) { return std::clamp(v, -(1 << 18), 1 << 18); };
            const Triangle t = {vertex_at(clamp(x - dx), clamp(y - dy), random),
                                vertex_at(clamp(x + dx + random.integer(-1, 1)),
                                          clamp(y + dy + random.integer(-1, 1)), random),
                                vertex_at(x, y, random)};
            if (const auto positive = oriented(t)) {
                check_region(*positive, 0, 0);
            }
        }
    }
    TEST_CASE("a region between the corners of the largest triangle is covered whole") {
        Random random(8);
        const int g = 16 * gp::guard_px;
        const auto t = oriented(
            {vertex_at(-g, -g, random), vertex_at(g, -g, random), vertex_at(0, g, random)});
        REQUIRE(t);
        // Its edges' values do not fit 32 bits here.
        CHECK(covers(*t, 64, 64));
        check_region(*t, 0, 0);
        check_region(*t, -128, -128);
    }
}

TEST_SUITE("gp/shared edges") {
    /// A lattice of jittered points over the whole picture, two triangles to the cell.
    std::vector<Triangle> jittered_grid(int cells, int size_px, int step, Random& random) {
        const int pitch = size_px * 16 / cells, reach = pitch / 5;  // A quarter could fold cells.
        std::vector<ScreenVertex> points;
        for (int j = 0; j <= cells; ++j) {
            for (int i = 0; i <= cells; ++i) {
                const bool border = i == 0 || j == 0 || i == cells || j == cells;
                const int dx = border ? 0 : random.integer(-reach, reach) / step * step;
                const int dy = border ? 0 : random.integer(-reach, reach) / step * step;
                points.push_back(vertex_at(i * pitch + dx, j * pitch + dy, random));
            }
        }
        std::vector<Triangle> triangles;
        for (int j = 0; j < cells; ++j) {
            for (int i = 0; i < cells; ++i) {
                const auto at = [&](int di, int dj) {
                    return points[static_cast<std::size_t>((j + dj) * (cells + 1) + i + di)];
                };
                if (random.integer(0, 1) == 0) {
                    triangles.push_back({at(0, 0), at(1, 0), at(0, 1)});
                    triangles.push_back({at(1, 0), at(1, 1), at(0, 1)});
                } else {
                    // Wound the other way: culling is off, so it must not matter.
                    triangles.push_back({at(0, 0), at(1, 1), at(1, 0)});
                    triangles.push_back({at(0, 0), at(0, 1), at(1, 1)});
                }
            }
        }
        return triangles;
    }

    void draw(const std::vector<Triangle>& triangles, const gp::RegionGrid& grid,
              gp::RegionPrograms& programs) {
        gp::DrawScratch scratch;
        programs.begin_frame(static_cast<std::size_t>(grid.count()));
        programs.begin_slab(0, 0);
        gp::draw_slab(slab_of(triangles), gp::prepare(pixel_camera(grid.width_px, grid.height_px)),
                      grid, {}, scratch, programs);
    }

    TEST_CASE("a triangulation of the picture covers every pixel exactly once") {
        for (const int step : {1, 8, 16}) {
            for (const int cells : {1, 2, 8, 64}) {
                Random random(100 + static_cast<std::uint64_t>(step * cells));
                const gp::RegionGrid grid = gp::region_grid(256, 256, 0);
                gp::RegionPrograms programs;
                draw(jittered_grid(cells, 256, step, random), grid, programs);
                const std::vector<int> counts = coverage(programs, grid);
                INFO("step ", step, " cells ", cells, " seed ", seed());
                CHECK(std::ranges::count(counts, 1) == std::ssize(counts));
            }
        }
    }

    TEST_CASE("a fan covers no pixel twice, and its inside once") {
        Random random(200);
        for (int round = 0; round < 20; ++round) {
            const ScreenVertex hub = vertex_at(random.integer(900, 1100) / 8 * 8,
                                               random.integer(900, 1100) / 8 * 8, random);
            const int spokes = random.integer(3, 40);
            std::vector<ScreenVertex> rim;
            for (int i = 0; i < spokes; ++i) {
                const double angle = 2 * 3.14159265358979 * i / spokes, r = random.real(400, 800);
                rim.push_back(vertex_at(hub.x + static_cast<int>(r * std::cos(angle)),
                                        hub.y + static_cast<int>(r * std::sin(angle)), random));
            }
            std::vector<Triangle> fan;
            for (std::size_t i = 0; i < rim.size(); ++i) {
                fan.push_back({hub, rim[i], rim[(i + 1) % rim.size()]});
            }
            const gp::RegionGrid grid = gp::region_grid(128, 128, 0);
            gp::RegionPrograms programs;
            draw(fan, grid, programs);
            const std::vector<int> counts = coverage(programs, grid);
            INFO("round ", round, " seed ", seed());
            CHECK(*std::ranges::max_element(counts) == 1);
            int missing = 0;
            const double inner = 400 * std::cos(3.14159265358979 / spokes) - 16;
            for (int y = 0; y < 128; ++y) {
                for (int x = 0; x < 128; ++x) {
                    const double d = std::hypot(16 * x + 8 - hub.x, 16 * y + 8 - hub.y);
                    missing += d < inner && counts[static_cast<std::size_t>(y * 128 + x)] == 0;
                }
            }
            CHECK(missing == 0);
        }
    }
}
