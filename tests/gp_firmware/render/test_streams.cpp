// Emitted streams, run by the reference executor, against a rasteriser in exact arithmetic.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "isa/program.hpp"
#include "isa/reference/reference.hpp"
#include "tests/gp_firmware/render/support.hpp"

using namespace pxpl5;
using namespace pxpl5::test;
namespace region = isa::region;

namespace {

/// Runs the words on `pixels`, instruction by instruction.
void run(std::span<const std::uint32_t> words, isa::Executor& pixels) {
    for (std::size_t at = 0; at < words.size();) {
        const auto in = isa::decode(words[at]);
        REQUIRE(in);
        std::array<std::int32_t, 3> coefficients{};
        const std::size_t count = isa::instruction_words(words[at]) - 1;
        for (std::size_t k = 0; k < count; ++k) {
            coefficients[k] = static_cast<std::int32_t>(words[at + 1 + k]);
        }
        pixels.execute(*in, {coefficients.data(), count});
        at += 1 + count;
    }
}

/// The plane through the corners' values at the center of a pixel, to 64 bits.
long double interpolated(const Triangle& t, int px, int py,
                         const std::array<std::int32_t, 3>& value) {
    const std::int64_t x = 16 * std::int64_t{px} + 8, y = 16 * std::int64_t{py} + 8;
    std::int64_t sum = 0;
    long double total = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const ScreenVertex &p = t[(k + 1) % 3], &q = t[(k + 2) % 3];
        const std::int64_t weight = (q.x - p.x) * (y - p.y) - (q.y - p.y) * (x - p.x);
        sum += weight;
        total += static_cast<long double>(weight) * value[k];
    }
    return total / static_cast<long double>(sum);
}

struct Winner {
    int surface = 0;
    long double z = 0, nx = 0, ny = 0, nz = 0;
};

/// Whose center is nearest at this pixel.
Winner nearest(std::span<const Triangle> triangles, int px, int py) {
    Winner winner;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        const auto t = oriented(triangles[i]);
        if (!t || !covers(*t, px, py)) {
            continue;
        }
        const Triangle& v = *t;
        const long double z = interpolated(v, px, py, {v[0].z, v[1].z, v[2].z});
        if (winner.surface == 0 || z < winner.z) {
            winner = {static_cast<int>(i) + 1, z,
                      interpolated(v, px, py, {v[0].nx, v[1].nx, v[2].nx}),
                      interpolated(v, px, py, {v[0].ny, v[1].ny, v[2].ny}),
                      interpolated(v, px, py, {v[0].nz, v[1].nz, v[2].nz})};
        }
    }
    return winner;
}

std::int64_t field(const isa::Executor& pixels, int x, int y, region::Field f, bool is_signed) {
    const auto bits = static_cast<std::int64_t>(pixels.field(x, y, f.address, f.width));
    const std::int64_t end = std::int64_t{1} << f.width;
    return is_signed && bits >= end / 2 ? bits - end : bits;
}

/// Draws each triangle as a surface of its own and compares a window of one region.
void check_window(const std::vector<Triangle>& triangles, int region_index,
                  isa::reference::Window window) {
    const gp::RegionGrid grid = gp::region_grid(256, 256, 0);
    const gp::Projection projection = gp::prepare(pixel_camera(256, 256));
    gp::RegionPrograms programs;
    gp::DrawScratch scratch;
    programs.begin_frame(static_cast<std::size_t>(grid.count()));
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        const auto index = static_cast<std::uint16_t>(i);
        programs.begin_slab(index, 0);
        gp::draw_slab(slab_of(std::span(&triangles[i], 1)), projection, grid, {index, false},
                      scratch, programs);
    }
    isa::reference::Reference pixels(window);
    const int x0 = region_index % grid.columns * 128, y0 = region_index / grid.columns * 128;
    for (int y = window.y0; y < window.y0 + window.height; ++y) {
        for (int x = window.x0; x < window.x0 + window.width; ++x) {
            pixels.set_field(x, y, region::z.address, region::z.width, region::z_far);
        }
    }
    const auto words = words_of(programs, static_cast<std::size_t>(region_index), grid);
    REQUIRE(isa::check(words).ok());
    run(words, pixels);

    int wrong = 0;
    for (int y = window.y0; y < window.y0 + window.height; ++y) {
        for (int x = window.x0; x < window.x0 + window.width; ++x) {
            const Winner expected = nearest(triangles, x0 + x, y0 + y);
            bool good = field(pixels, x, y, region::surface, false) == expected.surface;
            if (expected.surface != 0) {
                const auto near = [&](region::Field f, bool is_signed, long double value) {
                    return std::abs(static_cast<long double>(field(pixels, x, y, f, is_signed)) -
                                    value) < 2;
                };
                good = good && near(region::z, false, expected.z) &&
                       near(region::normal_x, true, expected.nx) &&
                       near(region::normal_y, true, expected.ny) &&
                       near(region::normal_z, true, expected.nz);
            } else {
                good = good && field(pixels, x, y, region::z, false) == region::z_far;
            }
            wrong += good ? 0 : 1;
        }
    }
    INFO("region ", region_index, " window ", window.x0, ",", window.y0, " seed ", seed());
    CHECK(wrong == 0);
}

/// Triangles with depths on a float's grid, so that the way through transform() does not move them.
std::vector<Triangle> random_triangles(int count, int spread, int x, int y, Random& random) {
    std::vector<Triangle> triangles;
    for (int i = 0; i < count; ++i) {
        Triangle t;
        for (ScreenVertex& v : t) {
            v = vertex_at(16 * x + random.integer(-spread, spread),
                          16 * y + random.integer(-spread, spread), random);
        }
        triangles.push_back(t);
    }
    return triangles;
}

}  // namespace

TEST_SUITE("gp/streams") {
    TEST_CASE("a triangle's words have the shape that Renderers know") {
        Random random(1);
        const gp::RegionGrid grid = gp::region_grid(256, 256, 0);
        gp::RegionPrograms programs;
        gp::DrawScratch scratch;
        programs.begin_frame(4);
        programs.begin_slab(6, 0);
        gp::draw_slab(slab_of(random_triangles(50, 2000, 128, 128, random)),
                      gp::prepare(pixel_camera(256, 256)), grid, {6, false}, scratch, programs);
        for (std::size_t r = 0; r < programs.regions().size(); ++r) {
            const auto words = words_of(programs, r, grid);
            REQUIRE(!words.empty());
            REQUIRE(words.size() % shape::word_count == 0);
            const isa::CheckResult result = isa::check(words);
            REQUIRE(result.ok());
            CHECK(result.facts.instructions ==
                  words.size() / shape::word_count * shape::instruction_count);
            for (std::size_t at = 0; at < words.size(); at += shape::word_count) {
                CHECK(shape::matches(&words[at]));
                CHECK(words[at + shape::at_surface] == shape::surface_word(7));
            }
        }
    }

    TEST_CASE("small triangles give the exact picture") {
        Random random(2);
        for (int round = 0; round < 6; ++round) {
            check_window(random_triangles(40, 60, 20, 20, random), 0, {12, 12, 16, 16});
        }
    }
    TEST_CASE("large triangles give the exact picture in each region that they cross") {
        Random random(3);
        for (int round = 0; round < 3; ++round) {
            const auto triangles = random_triangles(40, 3000, 128, 128, random);
            check_window(triangles, 0, {112, 112, 16, 16});
            check_window(triangles, 1, {0, 120, 16, 8});
            check_window(triangles, 2, {120, 0, 8, 16});
            check_window(triangles, 3, {0, 0, 16, 16});
        }
    }
}
