// Compares the region programs on the reference executor with Phong shading in doubles.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <stdexcept>

#include "isa/contract/region_layout.hpp"
#include "isa/reference/reference.hpp"
#include "isa/sequencer.hpp"
#include "renderer_firmware/igc/region_program.hpp"
#include "tests/isa/lockstep.hpp"
#include "tests/isa/random_program.hpp"
#include "tests/random_seed.hpp"
#include "tests/renderer_firmware/shaded.hpp"
#include "tests/renderer_firmware/targets.hpp"

using namespace pxpl5;
using namespace pxpl5::test;

namespace {

/// The greatest light of any normal: that of the longest sum of some of the lights.
double brightest_of(const Shading& s) {
    double most = 0;
    for (unsigned some = 0; some < 1U << s.lights.size(); ++some) {
        V3 sum{0, 0, 0};
        for (std::size_t i = 0; i < s.lights.size(); ++i) {
            const V3 l =
                unit({s.lights[i].direction.x, s.lights[i].direction.y, s.lights[i].direction.z});
            const double share = (some >> i & 1) != 0 ? s.lights[i].intensity : 0;
            sum = {sum.x + share * l.x, sum.y + share * l.y, sum.z + share * l.z};
        }
        most = std::max(most, std::sqrt(dot(sum, sum)));
    }
    return s.ambient + most;
}

/// The tone curve: straight up to a knee, then a parabola that ends at `limit` with the brightest
/// light. Beyond twice the limit it is level.
double bent(double light, double brightest, double limit) {
    if (brightest <= limit) {
        return light;
    }
    const double end = std::min(brightest, 2 * limit);
    const double width = std::max(2 * (end - limit), 0.27), knee = end - width;
    const double above = std::min(light, end) - knee;
    return above <= 0 ? light : knee + above - (end - limit) * above * above / (width * width);
}

/// Returns the color by the Phong formula.
std::array<double, 3> phong(const Shading& s, const Covered& c) {
    const Rgb color = s.surfaces[static_cast<std::size_t>(c.surface - 1)];
    const double flip = c.normal[2] < 0 ? -1 : 1;
    const V3 n = unit({flip * c.normal[0], flip * c.normal[1], flip * c.normal[2]});
    double light = s.ambient, gloss = 0;
    for (const Light& lamp : s.lights) {
        const V3 l = unit({lamp.direction.x, lamp.direction.y, lamp.direction.z});
        const V3 h = unit({l.x, l.y, l.z + 1});
        light += lamp.intensity * std::max(0.0, dot(n, l));
        gloss += double{lamp.intensity} * s.specular *
                 std::pow(std::max(0.0, dot(n, h)), s.specular_power);
    }
    const auto at = static_cast<std::size_t>(c.surface - 1);
    const double rim = at < s.rims.size() ? s.rims[at] : 0;
    const double limit = 255.0 / std::max({color.r, color.g, color.b, std::uint8_t{1}});
    light = bent(light, brightest_of(s), limit);
    light = std::min(light + 2 * rim * (1 - n.z) * (1 - n.z), std::min(limit, 4.0));
    const auto mixed = [&](std::uint8_t value) {
        return std::min(255.0, value * light + 255 * gloss);
    };
    return {mixed(color.r), mixed(color.g), mixed(color.b)};
}

/// Returns the largest difference of any channel from the formula; background pixels must be exact.
double worst_error(const Shading& shading, const std::vector<Covered>& pixels) {
    const std::vector<Color> found = shade(shading, pixels);
    double worst = 0;
    for (std::size_t i = 0; i < pixels.size(); ++i) {
        if (pixels[i].surface == 0) {
            const Rgb b = shading.background;
            CHECK(found[i] == Color{b.r, b.g, b.b});
            continue;
        }
        const std::array<double, 3> wanted = phong(shading, pixels[i]);
        for (std::size_t k = 0; k < 3; ++k) {
            worst = std::max(worst, std::abs(found[i][k] - wanted[k]));
        }
    }
    return worst;
}

}  // namespace

TEST_CASE("shaded pixels are within 2 of 255 of Phong's formula, the background is exact") {
    const std::uint64_t seed = test::seed_or<std::uint64_t>(51);
    INFO("PXPL5_SEED=", seed);
    ShadingRandom random(seed);
    double worst = 0, worst_at_unit = 0;
    for (int round = 0; round < 120; ++round) {
        const Shading shading = random_shading(random, round % 5);
        const bool short_normals = round % 2 == 0;
        std::vector<Covered> pixels(pixel_count);
        for (Covered& pixel : pixels) {
            const int count = static_cast<int>(shading.surfaces.size());
            if (random.below(5) != 0) {
                const double length = short_normals ? random.between(200, 510) : 510;
                pixel = covered(random, 1 + random.below(count), length);
            }
        }
        INFO("round ", round, ", power ", shading.specular_power);
        const double error = worst_error(shading, pixels);
        CHECK(error <= 2);
        (short_normals ? worst : worst_at_unit) =
            std::max(short_normals ? worst : worst_at_unit, error);
    }
    MESSAGE(fmt::format("worst error {:.2f} for normals of length 200..510, {:.2f} for unit ones",
                        worst, worst_at_unit));
}

TEST_CASE("every specular power follows the formula around the highlight") {
    ShadingRandom random(test::seed_or<std::uint64_t>(52));
    double worst = 0;
    for (std::uint32_t power = 1; power <= max_specular_power; ++power) {
        Shading shading = white_lamp({0.3F, -0.2F, 0.9F});
        shading.specular = 1;
        shading.specular_power = power;
        shading.surfaces = {{0, 0, 0}};
        std::vector<Covered> pixels(pixel_count);
        const V3 half = unit({0.3, -0.2, 0.9 + std::sqrt(0.94)});
        for (Covered& pixel : pixels) {
            const V3 off = random.direction();
            const double spread = random.between(0, 0.5);
            const V3 n =
                unit({half.x + spread * off.x, half.y + spread * off.y, half.z + spread * off.z});
            pixel = {
                1,
                {static_cast<int>(std::lround(510 * n.x)), static_cast<int>(std::lround(510 * n.y)),
                 static_cast<int>(std::lround(510 * n.z))}};
        }
        INFO("power ", power);
        const double error = worst_error(shading, pixels);
        CHECK(error <= 2);
        worst = std::max(worst, error);
    }
    MESSAGE(fmt::format("worst error {:.2f}", worst));
}

TEST_CASE("a surface looks the same from both of its sides") {
    ShadingRandom random(test::seed_or<std::uint64_t>(53));
    Shading shading = random_shading(random, 3);
    std::vector<Covered> front(pixel_count);
    for (Covered& pixel : front) {
        do {
            pixel = covered(random, 1, random.between(200, 510));
        } while (pixel.normal[2] == 0);
    }
    std::vector<Covered> back = front;
    for (Covered& pixel : back) {
        for (int& component : pixel.normal) {
            component = -component;
        }
    }
    CHECK(shade(shading, front) == shade(shading, back));
}

TEST_CASE("the brightest channel is held at 255, and the hue stays") {
    Shading shading = white_lamp({0, 0, 1});
    shading.lights[0].intensity = 2;
    shading.specular = 1;
    shading.specular_power = 1;
    const std::vector<Covered> facing(pixel_count, {1, {0, 0, 510}});
    CHECK(shade(shading, facing)[0] == Color{255, 255, 255});
    shading.specular = 0;
    CHECK(shade(shading, facing)[0] == Color{255, 127, 64});
    shading.ambient = 1.75F;
    shading.surfaces = {{20, 40, 10}, {100, 200, 50}};
    std::vector<Covered> both = facing;
    both[1].surface = 2;
    CHECK(shade(shading, both)[0] == Color{75, 150, 38});  // 3.75 times: not overexposed.
    CHECK(shade(shading, both)[1] == Color{127, 255, 64});
}

TEST_CASE("lights that overexpose nothing cost nothing") {
    const auto instructions = [](std::vector<Light> lights, std::uint8_t red) {
        Shading shading = white_lamp({0, 0, 1});
        shading.lights = std::move(lights);
        shading.surfaces = {{red, 100, 50}};
        return renderer::region_programs(shading).end_of_region.size();
    };
    CHECK(instructions({{{0, 0, 1}, 1.27F}}, 200) < instructions({{{0, 0, 1}, 1.28F}}, 200));
    // No normal faces both lights wholly: together they are 0.9 times the root of 1.04 at most.
    const std::vector<Light> apart = {{{0, 0.6F, 0.8F}, 0.9F}, {{0.6F, -0.8F, 0}, 0.9F}};
    CHECK(instructions(apart, 255) == instructions(apart, 10));
}

TEST_CASE("a rim adds light at the edges of its surface alone, without lights, too") {
    Shading shading;
    shading.ambient = 0.25F;
    shading.surfaces = {{200, 100, 40}, {200, 100, 40}, {200, 100, 40}};
    shading.rims = {0, 1};
    std::vector<Covered> pixels(pixel_count, {2, {0, 0, 510}});
    pixels[1].normal = {0, -510, 0};
    pixels[2].normal = {361, 0, 361};
    pixels[3].normal = {361, 0, -361};
    pixels[4].normal = {0, 0, 0};
    pixels[5] = {1, {0, -510, 0}};
    pixels[6] = {3, {0, -510, 0}};
    const std::vector<Color> found = shade(shading, pixels);
    const Color ambient = {50, 25, 10};
    CHECK(found[0] == ambient);
    CHECK(found[1][0] == 255);  // 0.25 + 2, cut so that red is 255 and the hue stays.
    CHECK(found[1][2] == 51);
    CHECK(found[2] == Color{84, 42, 17});  // At 45 degrees: 0.25 + 2 x 0.293 squared.
    CHECK(found[3] == found[2]);
    for (const std::size_t at : {4U, 5U, 6U}) {
        CHECK(found[at] == ambient);
    }
    const auto size = [](const Shading& s) { return renderer::end_of_region(s).size(); };
    shading.rims = {0, 0, 0};
    Shading without = shading;
    without.rims = {};
    CHECK(size(shading) == size(without));
}

TEST_CASE("rims and lights together follow the formula up to the light that a pixel can hold") {
    ShadingRandom random(test::seed_or<std::uint64_t>(56));
    Shading shading = white_lamp({0, 1, 0.1F});
    shading.lights[0].intensity = 3.6F;
    shading.surfaces = {{60, 30, 10}, {255, 200, 10}, {130, 130, 130}};
    shading.rims = {1, 1, 0.5F};
    std::vector<Covered> pixels(pixel_count);
    for (Covered& pixel : pixels) {
        pixel = covered(random, 1 + random.below(3), random.between(200, 510));
    }
    pixels[0] = {1, {0, 510, 0}};
    CHECK(worst_error(shading, pixels) <= 2);
}

TEST_CASE("black stays black and white stays white") {
    Shading shading = white_lamp({0, 0, 1});
    shading.surfaces = {{0, 0, 0}, {255, 255, 255}};
    std::vector<Covered> pixels(pixel_count, {1, {0, 0, 510}});
    pixels[1].surface = 2;
    pixels[2] = {2, {510, 0, 0}};
    const std::vector<Color> found = shade(shading, pixels);
    CHECK(found[0] == Color{0, 0, 0});
    CHECK(found[1] == Color{255, 255, 255});
    CHECK(found[2] == Color{0, 0, 0});
}

TEST_CASE("255 surfaces keep their colors") {
    Shading shading = white_lamp({0, 0, 1});
    std::vector<Covered> pixels(pixel_count);
    for (int i = 1; i <= 255; ++i) {
        const auto c = static_cast<std::uint8_t>(i);
        shading.surfaces.resize(static_cast<std::size_t>(i), {c, static_cast<std::uint8_t>(255 - c),
                                                              static_cast<std::uint8_t>(7 * c)});
        pixels[static_cast<std::size_t>(i)] = {i, {0, 0, 510}};
    }
    CHECK(worst_error(shading, pixels) <= 1);
}

TEST_CASE("normals of any length are safe, those of length 0 get the ambient light") {
    Shading shading = white_lamp({0.5F, 0.5F, 0.7F});
    shading.ambient = 0.5F;
    shading.rims = {1};
    std::vector<Covered> pixels;
    for (int i = 0; i < pixel_count; ++i) {
        pixels.push_back({1, {i % 16 - 8, i / 16 - 8, 3}});
    }
    CHECK(worst_error(shading, pixels) <= 2);
    shading.rims = {0.25F};
    CHECK(worst_error(shading, pixels) <= 2);
    pixels.assign(pixel_count, {1, {0, 0, 0}});
    shading.lights[0].intensity = 0.5F;
    CHECK(shade(shading, pixels)[0] == Color{100, 50, 25});
    pixels.assign(pixel_count, {1, {511, 511, 511}});
    CHECK(worst_error(shading, pixels) <= 2);
}

TEST_CASE("the fast executor shades bit for bit as the reference does") {
    const std::uint64_t seed = test::seed_or<std::uint64_t>(54);
    INFO("PXPL5_SEED=", seed);
    test::on_every_target([seed](renderer::fast::Fast& fast) {
        ShadingRandom random(seed);
        for (int lights = 0; lights <= 4; ++lights) {
            Shading shading = random_shading(random, lights);
            shading.planes = lights % 2 == 0 ? 0 : shading.surfaces.size();
            isa::reference::Reference trusted(window);
            fast.reset();
            test::Lockstep both(trusted, fast);
            execute(both, renderer::prologue(shading));
            // Half a disc of surface 1, with varying normals.
            const std::int32_t disc[] = {100, 110, -4000, -1, 0, -1};
            both.execute({isa::Op::quad_ge_zero, {0, 0, 32}}, disc);
            both.execute({isa::Op::imm_into_mem, {isa::region::surface.address, 1, 8}}, {});
            for (const isa::region::Field field :
                 {isa::region::normal_x, isa::region::normal_y, isa::region::normal_z}) {
                const std::int32_t plane[] = {random.below(600) - 300, random.below(600) - 300,
                                              random.below(20000) - 10000};
                both.execute({isa::Op::tree_into_mem, {field.address, 7, field.width}}, plane);
            }
            CHECK_NOTHROW(execute(both, renderer::end_of_region(shading)));
        }
    });
}

TEST_CASE("an empty region is read out and not shaded") {
    Shading shading = white_lamp({0, 0, 1});
    shading.background = {1, 2, 3};
    isa::reference::Reference pixels(window);
    execute(pixels, renderer::prologue(shading));
    const std::vector<std::uint32_t> words = renderer::end_of_region(shading);
    isa::Controller controller;
    CHECK(isa::run(words, pixels, controller).instructions == 6);
    CHECK(pixels.field(window.x0, window.y0, 64, 24) == 0x030201);
    CHECK(pixels.field(window.x0, window.y0, 8, 24) == isa::region::z_far);
}

TEST_CASE("one lamp takes at most 80 instructions") {
    Shading shading = white_lamp({0.5F, 0.5F, 0.7F});
    shading.specular = 0.5F;
    for (const std::uint32_t power : {32U, 127U}) {
        shading.specular_power = power;
        const std::size_t count = isa::check(renderer::end_of_region(shading)).facts.instructions;
        MESSAGE("power ", power, ": ", count, " instructions");
        CHECK(count <= (power == 32 ? 80U : 100U));
    }
}

TEST_CASE("shadings out of range are refused with value and limit") {
    const auto refused = [](auto change, const char* what) {
        Shading shading = white_lamp({0, 0, 1});
        change(shading);
        CHECK_THROWS_WITH_AS(renderer::end_of_region(shading), what, std::invalid_argument);
        CHECK_THROWS_AS(renderer::prologue(shading), std::invalid_argument);
    };
    refused([](Shading& s) { s.lights.resize(5, s.lights[0]); }, "shading: 5 lights; at most 4");
    refused([](Shading& s) { s.surfaces.resize(256); }, "shading: 256 surfaces; at most 255");
    refused([](Shading& s) { s.specular_power = 0; }, "shading: specular power 0; must be 1..128");
    refused([](Shading& s) { s.specular_power = 129; },
            "shading: specular power 129; must be 1..128");
    refused([](Shading& s) { s.rims = {0, 0}; }, "shading: 2 rims of 1 surfaces");
    refused([](Shading& s) { s.rims = {1.5F}; }, "shading: rim 1.5; must be 0..1");
    refused([](Shading& s) { s.specular = 1.5F; }, "shading: specular 1.5; must be 0..1");
    refused([](Shading& s) { s.ambient = NAN; }, "shading: ambient nan; must not be negative");
    refused(
        [](Shading& s) {
            s.lights[0].direction = {0, 0, 0};
        },
        "shading: a light's direction (0, 0, 0) has no length");
    refused([](Shading& s) { s.lights[0].intensity = 3.5F, s.ambient = 0.5F; },
            "shading: ambient and intensities sum up to 4; at most 3.9");
}
