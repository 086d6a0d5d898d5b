// Tests the colors of slice planes beside those of surfaces.
#include <doctest/doctest.h>

#include <stdexcept>

#include "tests/random_seed.hpp"
#include "tests/renderer_firmware/shaded.hpp"

using namespace pxpl5;
using namespace pxpl5::test;

TEST_CASE("a slice plane has its gray values, whatever the lights and the other surfaces are") {
    ShadingRandom random(test::seed_or<std::uint64_t>(54));
    for (int lights = 0; lights <= 4; ++lights) {
        for (const int planes : {1, 3}) {
            Shading lit = random_shading(random, lights);
            const int surfaces = static_cast<int>(lit.surfaces.size());
            Shading shading = lit;
            shading.surfaces.resize(shading.surfaces.size() + static_cast<std::size_t>(planes));
            shading.planes = static_cast<std::size_t>(planes);
            std::vector<Covered> pixels(pixel_count), only_lit(pixel_count);
            for (int i = 0; i < pixel_count; ++i) {
                const auto at = static_cast<std::size_t>(i);
                const bool is_gray = i % 2 == 0;
                pixels[at] = is_gray ? Covered{surfaces + 1 + i % 3 % planes, {0, 0, 2 * i + 1}}
                                     : covered(random, 1 + random.below(surfaces), 510);
                only_lit[at] = is_gray ? Covered{} : pixels[at];
            }
            const std::vector<Color> found = shade(shading, pixels), wanted = shade(lit, only_lit);
            for (int i = 0; i < pixel_count; ++i) {
                const auto at = static_cast<std::size_t>(i);
                CHECK(found[at] == (i % 2 == 0 ? Color{i, i, i} : wanted[at]));
            }
        }
    }
}

TEST_CASE("a frame of slice planes alone has their gray values") {
    Shading shading = white_lamp({0, 0, 1});
    shading.planes = 1;
    std::vector<Covered> pixels(pixel_count, {1, {0, 0, 510}});
    pixels[1].normal = {0, 0, 1};
    pixels[2].surface = 0;
    const std::vector<Color> found = shade(shading, pixels);
    CHECK(found[0] == Color{255, 255, 255});
    CHECK(found[1] == Color{0, 0, 0});
    CHECK(found[2] == Color{0, 0, 0});  // The background.
    shading.planes = 2;
    CHECK_THROWS_WITH_AS(renderer::region_programs(shading),
                         "shading: 2 slice planes among 1 surfaces", std::invalid_argument);
}
