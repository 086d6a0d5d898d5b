// Shades a window of pixels with the region programs, on the reference executor.
#pragma once

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "isa/contract/region_layout.hpp"
#include "isa/reference/reference.hpp"
#include "isa/sequencer.hpp"
#include "renderer_firmware/igc/region_program.hpp"

namespace pxpl5::test {

using renderer::Light;
using renderer::Rgb;
using renderer::Shading;

inline constexpr int window_side = 16;
inline constexpr isa::reference::Window window{
    .x0 = 32, .y0 = 48, .width = window_side, .height = window_side};
inline constexpr int pixel_count = window_side * window_side;

/// The fields of a pixel after the triangles; components in field units.
struct Covered {
    int surface = 0;
    std::array<int, 3> normal{};
};

using Color = std::array<int, 3>;

inline void execute(isa::Executor& pixels, const std::vector<std::uint32_t>& words) {
    const isa::CheckResult result = isa::check(words);
    REQUIRE_MESSAGE(result.ok(), "word ", result.error->word, ": ", result.error->text);
    isa::Controller controller;
    isa::run(words, pixels, controller);
}

inline void store(isa::reference::Reference& pixels, int x, int y, isa::region::Field field,
                  int value) {
    pixels.set_field(x, y, field.address, field.width, static_cast<std::uint64_t>(value));
}

/// Draws `covered` (window_side * window_side pixels, row by row) with the two programs.
inline std::vector<Color> shade(const Shading& shading, const std::vector<Covered>& covered) {
    isa::reference::Reference pixels(window);
    std::vector<Color> colors;
    pixels.set_readout([&](auto words) {
        for (int i = 0; i < pixel_count; ++i) {
            const int x = window.x0 + i % window_side, y = window.y0 + i / window_side;
            const std::uint32_t word = words[static_cast<std::size_t>(y * 128 + x)];
            colors.push_back({static_cast<int>(word & 255), static_cast<int>(word >> 8 & 255),
                              static_cast<int>(word >> 16)});
        }
    });
    const renderer::RegionPrograms programs = renderer::region_programs(shading);
    execute(pixels, programs.prologue);
    for (int i = 0; i < pixel_count; ++i) {
        const int x = window.x0 + i % window_side, y = window.y0 + i / window_side;
        const Covered& c = covered[static_cast<std::size_t>(i)];
        if (c.surface != 0) {
            store(pixels, x, y, isa::region::surface, c.surface);
            store(pixels, x, y, isa::region::normal_x, c.normal[0]);
            store(pixels, x, y, isa::region::normal_y, c.normal[1]);
            store(pixels, x, y, isa::region::normal_z, c.normal[2]);
        }
    }
    execute(pixels, programs.end_of_region);
    REQUIRE(colors.size() == pixel_count);
    return colors;
}

struct V3 {
    double x, y, z;
};
inline double dot(V3 p, V3 q) {
    return p.x * q.x + p.y * q.y + p.z * q.z;
}
inline V3 unit(V3 v) {
    const double length = std::sqrt(dot(v, v));
    return {v.x / length, v.y / length, v.z / length};
}

class ShadingRandom {
  public:
    explicit ShadingRandom(std::uint64_t seed) : bits_(seed) {}
    double between(double low, double high) {
        return low + (high - low) * static_cast<double>(bits_() >> 11) * 0x1p-53;
    }
    int below(int count) { return static_cast<int>(bits_() % static_cast<unsigned>(count)); }
    V3 direction() {
        for (;;) {
            const V3 v{between(-1, 1), between(-1, 1), between(-1, 1)};
            const double square = dot(v, v);
            if (square > 0.01 && square < 1) {
                return unit(v);
            }
        }
    }
    Rgb color() {
        const auto part = [&] { return static_cast<std::uint8_t>(below(256)); };
        return {part(), part(), part()};
    }

  private:
    std::mt19937_64 bits_;
};

inline Covered covered(ShadingRandom& random, int surface, double length) {
    const V3 n = random.direction();
    const auto part = [&](double v) { return static_cast<int>(std::lround(v * length)); };
    return {surface, {part(n.x), part(n.y), part(n.z)}};
}

inline Shading random_shading(ShadingRandom& random, int lights) {
    Shading s;
    s.ambient = static_cast<float>(random.between(0, 0.4));
    s.specular = static_cast<float>(random.between(0, 1));
    s.specular_power = static_cast<std::uint32_t>(1 + random.below(128));
    s.background = random.color();
    for (int i = 0; i < lights; ++i) {
        V3 d = random.direction();
        d.z = random.below(2) == 0 ? d.z : std::abs(d.z);
        s.lights.push_back(
            {{static_cast<float>(d.x), static_cast<float>(d.y), static_cast<float>(d.z)},
             static_cast<float>(random.between(0.1, 3.5 / lights))});
    }
    for (int i = random.below(4); i >= 0; --i) {
        s.surfaces.push_back(random.color());
        if (random.below(2) == 0) {  // The last surfaces may have no entry.
            s.rims.resize(s.surfaces.size());
            s.rims.back() = static_cast<float>(random.below(17)) / 16;
        }
    }
    return s;
}

inline Shading white_lamp(Light::Direction direction) {
    Shading s;
    s.lights = {{direction, 1}};
    s.ambient = 0;
    s.specular = 0;
    s.surfaces = {{200, 100, 50}};
    return s;
}

}  // namespace pxpl5::test
