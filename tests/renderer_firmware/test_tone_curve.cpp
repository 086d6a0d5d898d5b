// Tests the tone curve in the integers of bend_light.pxasm, for many lights and colors.
#include <doctest/doctest.h>

#include <cstdlib>

#include "renderer_firmware/igc/tone_curve.hpp"
#include "ringbus/rules/light_sum.hpp"

using namespace pxpl5;
using renderer::ToneCurve;

namespace {

/// The field `light` after the program.
std::int64_t bent(std::int64_t light, const ToneCurve& curve) {
    if (curve.cut && light >= *curve.cut) {
        light = *curve.cut;
    }
    if (light >= curve.knee) {
        const std::int64_t above = light - curve.knee;
        light -= ((above * above >> 16) * curve.bend >> 13) & 0xffff;
    }
    return std::min(light, curve.limit);
}

}  // namespace

TEST_CASE("a tone curve rises without a corner from the knee to the limit, in 16 bits") {
    int curves = 0;
    for (double brightest = 1; brightest <= double{bus::max_light_sum}; brightest += 0.03) {
        for (const int channel : {255, 254, 236, 200, 150, 100, 70, 66}) {
            const auto curve = renderer::tone_curve(brightest, channel);
            if (!curve) {
                CHECK(brightest <= 255.0 / channel);
                continue;
            }
            ++curves;
            CAPTURE(brightest);
            CAPTURE(channel);
            CHECK(curve->knee >= 0);
            CHECK(curve->bend > 0);
            CHECK(curve->bend < 1 << 16);
            CHECK(curve->cut.value_or(0) < 1 << 16);
            const auto last = std::llround(brightest * 16384 + 16);
            std::int64_t before = bent(0, *curve), most_step = 0, most_fall = 0;
            for (std::int64_t light = 1; light <= last; ++light) {
                const std::int64_t now = bent(light, *curve);
                most_step = std::max(most_step, now - before);
                most_fall = std::max(most_fall, before - now);
                before = now;
            }
            // A step of the squared light is that of several units of the result.
            CHECK(most_step <= 2 + curve->bend / 8192);
            CHECK(most_fall <= 2 + curve->bend / 8192);
            // 1/512 is the step of the light that colors are multiplied by.
            CHECK(std::abs(before - curve->limit) <= 64);
            CHECK(bent(curve->knee, *curve) == std::min(curve->knee, curve->limit));
        }
    }
    CHECK(curves > 300);
}

TEST_CASE("a surface that no light overexposes has no tone curve") {
    CHECK_FALSE(renderer::tone_curve(1.27, 200));
    CHECK(renderer::tone_curve(1.28, 200));
    CHECK_FALSE(renderer::tone_curve(3.9, 0));
}
