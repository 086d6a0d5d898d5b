#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/serve/video/video_encoder.hpp"
#include "tests/host/serve/moving_pictures.hpp"

namespace pxpl5::host::serve {
namespace {

using test::Pixels, test::psnr;
using Decoder = test::VideoDecoder;
constexpr std::size_t plenty = 1'000'000;

/// A shaded ball before a background, moved to the right by `step` pixels.
Pixels ball(int width, int height, int step) {
    Pixels pixels;
    const double radius = std::min(width, height) * 0.4;
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const double dx = (x - width * 0.4 - step) / radius, dy = (y - height * 0.5) / radius;
            const double z2 = 1 - dx * dx - dy * dy;
            const double light = z2 > 0 ? 0.2 + 0.8 * std::sqrt(z2) : 0.1;
            const auto part = [&](double color) {
                return static_cast<std::uint32_t>(255 * light * color);
            };
            pixels.push_back(0xff000000U | part(0.9) | part(0.75) << 8U | part(0.55) << 16U);
        }
    }
    return pixels;
}

/// Rings around a center that is moved: each pixel changes.
Pixels waves(int width, int height, double moved) {
    Pixels pixels;
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const double dx = x - width / 2.0 - moved, dy = y - height / 2.0;
            const double light = 0.5 + 0.5 * std::sin((dx * dx + dy * dy) / 200);
            pixels.push_back(0xff000000U | static_cast<std::uint32_t>(255 * light) * 0x010101U);
        }
    }
    return pixels;
}

}  // namespace

TEST_CASE("the first frame of a video is a key, the others are not, and each is decoded at once") {
    VideoEncoder encoder;
    Decoder decoder;
    for (int step = 0; step < 30; ++step) {
        CAPTURE(step);
        const Pixels picture = ball(256, 192, step);
        const VideoEncoder::Frame frame = encoder.encode(256, 192, picture, plenty);
        CHECK(frame.is_key == (step == 0));
        CHECK(psnr(picture, decoder.decode(frame.bytes)) > 34);
    }
}

TEST_CASE("a picture of another size, also an odd one, is a key that needs no other frame") {
    VideoEncoder encoder;
    Decoder decoder;
    struct Size {
        int width, height;
    };
    for (const Size size : {Size{64, 48}, {61, 43}, {1, 1}, {2, 97}, {64, 48}}) {
        const int width = size.width, height = size.height;
        CAPTURE(width);
        for (const bool is_first : {true, false}) {
            const Pixels picture = ball(width, height, is_first ? 0 : 2);
            const auto frame = encoder.encode(width, height, picture, plenty);
            CHECK(frame.is_key == is_first);
            CHECK(psnr(picture, decoder.decode(frame.bytes)) > 30);
            CHECK(decoder.width == width);
            CHECK(decoder.height == height);
            if (is_first) {
                CHECK(Decoder().decode(frame.bytes).size() == picture.size());
            }
        }
    }
}

TEST_CASE("a frame that is not a key cannot be decoded without those before it") {
    VideoEncoder encoder;
    (void)encoder.encode(64, 48, ball(64, 48, 0), plenty);
    CHECK(Decoder().decode(encoder.encode(64, 48, ball(64, 48, 1), plenty).bytes).empty());
}

TEST_CASE("frames have the bytes of the goal on average, also after the goal changes") {
    VideoEncoder encoder;
    int step = 0;
    const auto mean_bytes = [&](std::size_t goal) {
        double sum = 0;
        constexpr int frames = 50;
        for (int i = 0; i < frames; ++i, ++step) {
            const double angle = step * 2 * std::numbers::pi / 40;
            const Pixels picture = waves(320, 240, 60 * std::sin(angle));
            sum += static_cast<double>(encoder.encode(320, 240, picture, goal).bytes.size());
        }
        return sum / frames;
    };
    const double ample = mean_bytes(plenty);
    for (const double share : {0.6, 0.3, 0.6}) {
        CAPTURE(share);
        const double goal = ample * share;
        CHECK(mean_bytes(static_cast<std::size_t>(goal)) == doctest::Approx(goal).epsilon(0.3));
    }
}

TEST_CASE("a picture that VP8 cannot hold is refused with its limit") {
    VideoEncoder encoder;
    const Pixels wide(max_video_px + 1);
    CHECK_THROWS_WITH_AS(encoder.encode(max_video_px + 1, 1, wide, plenty),
                         "cannot encode a video of 16384 x 1: VP8 has 1 to 16383 columns and rows",
                         std::runtime_error);
    CHECK(encoder.encode(8, 8, Pixels(64), plenty).is_key);
}

}  // namespace pxpl5::host::serve
