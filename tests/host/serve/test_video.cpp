#include <doctest/doctest.h>
#include <vpx/vp8dx.h>
#include <vpx/vpx_decoder.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "host/serve/video/video_encoder.hpp"

namespace pxpl5::host::serve {
namespace {

using Pixels = std::vector<std::uint32_t>;
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

/// libvpx's decoder. Pixels come back by the inverse of BT.601.
class Decoder {
  public:
    Decoder() { REQUIRE(vpx_codec_dec_init(&codec_, vpx_codec_vp8_dx(), nullptr, 0) == 0); }
    ~Decoder() { vpx_codec_destroy(&codec_); }
    Decoder(const Decoder&) = delete;
    Decoder& operator=(const Decoder&) = delete;

    /// The picture, at once; empty if it cannot be decoded.
    Pixels decode(const std::string& bytes) {
        if (vpx_codec_decode(&codec_, reinterpret_cast<const std::uint8_t*>(bytes.data()),
                             static_cast<unsigned>(bytes.size()), nullptr, 0) != 0) {
            return {};
        }
        vpx_codec_iter_t next = nullptr;
        const vpx_image_t* image = vpx_codec_get_frame(&codec_, &next);
        Pixels pixels;
        if (image != nullptr) {
            width = static_cast<int>(image->d_w);
            height = static_cast<int>(image->d_h);
            for (int y = 0; y < height; ++y) {
                for (int x = 0; x < width; ++x) {
                    pixels.push_back(pixel_of(*image, x, y));
                }
            }
        }
        return pixels;
    }

    int width = 0, height = 0;

  private:
    static std::uint32_t pixel_of(const vpx_image_t& image, int x, int y) {
        const auto at = [&](int plane, int column, int row) {
            return static_cast<double>(image.planes[plane][row * image.stride[plane] + column]);
        };
        const double brightness = 1.164 * (at(0, x, y) - 16);
        const double blue = at(1, x / 2, y / 2) - 128, red = at(2, x / 2, y / 2) - 128;
        const auto byte = [](double value) {
            return static_cast<std::uint32_t>(std::clamp(std::round(value), 0.0, 255.0));
        };
        return 0xff000000U | byte(brightness + 1.596 * red) |
               byte(brightness - 0.392 * blue - 0.813 * red) << 8U |
               byte(brightness + 2.017 * blue) << 16U;
    }

    vpx_codec_ctx_t codec_{};
};

/// Peak signal-to-noise ratio of red, green and blue, in dB.
double psnr(const Pixels& a, const Pixels& b) {
    REQUIRE(a.size() == b.size());
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        for (const unsigned shift : {0U, 8U, 16U}) {
            const int d =
                static_cast<int>(a[i] >> shift & 0xffU) - static_cast<int>(b[i] >> shift & 0xffU);
            sum += d * d;
        }
    }
    return 10 * std::log10(255.0 * 255.0 / (sum / static_cast<double>(a.size() * 3) + 1e-9));
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
    for (const auto [width, height] : {Size{64, 48}, {61, 43}, {1, 1}, {2, 97}, {64, 48}}) {
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

TEST_CASE("frames have the size that they may have, and follow when it changes") {
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
