#include <doctest/doctest.h>
#include <png.h>

#include <cmath>
#include <cstring>

#include "host/serve/encoding/encode.hpp"
#include "tests/host/serve/moving_pictures.hpp"

namespace pxpl5::host::serve {
namespace {

constexpr int width_px = 61, height_px = 43;  // No multiple of a JPEG's blocks.

using test::Pixels;

/// Every byte of the pixels varies, and quickly.
Pixels noise() {
    Pixels pixels(width_px * height_px);
    std::uint32_t state = 1;
    for (std::uint32_t& pixel : pixels) {
        state = state * 1664525U + 1013904223U;
        pixel = 0xff000000U | state >> 8U;
    }
    return pixels;
}

Pixels gradient() {
    Pixels pixels;
    for (int y = 0; y < height_px; ++y) {
        for (int x = 0; x < width_px; ++x) {
            pixels.push_back(0xff000000U | static_cast<std::uint32_t>(x * 4) |
                             static_cast<std::uint32_t>(y * 5) << 8U | 100U << 16U);
        }
    }
    return pixels;
}

Pixels decoded_png(const std::string& bytes) {
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    REQUIRE(png_image_begin_read_from_memory(&image, bytes.data(), bytes.size()) != 0);
    REQUIRE(image.width == width_px);
    REQUIRE(image.height == height_px);
    image.format = PNG_FORMAT_RGBA;
    Pixels pixels(width_px * height_px);
    REQUIRE(png_image_finish_read(&image, nullptr, pixels.data(), 0, nullptr) != 0);
    return pixels;
}

Pixels decoded_jpeg(const std::string& bytes) {
    return test::decoded_jpeg(bytes, width_px, height_px);
}

/// Root of the mean squared difference of red, green and blue.
double difference(const Pixels& a, const Pixels& b) {
    return std::sqrt(test::mean_square(a, b));
}

}  // namespace

TEST_CASE("a PNG holds the very pixels") {
    CHECK(decoded_png(png_of(width_px, height_px, noise())) == noise());
    CHECK(decoded_png(png_of(width_px, height_px, gradient())) == gradient());
}

TEST_CASE("a JPEG holds a smooth picture, red still red, the better the higher its quality") {
    const Pixels picture = gradient();
    const double good =
        difference(picture, decoded_jpeg(jpeg_of(width_px, height_px, picture, {90, false})));
    const double poor =
        difference(picture, decoded_jpeg(jpeg_of(width_px, height_px, picture, {50, false})));
    CHECK(good < 2.5);
    CHECK(poor < 6);
    CHECK(good < poor);
}

TEST_CASE("layers are blended by sixteenths, for each view and channel") {
    const Pixels behind = noise(), front = gradient();
    Pixels stack;
    for (const Pixels& each : {behind, front, front, behind}) {
        stack.insert(stack.end(), each.begin(), each.end());
    }
    for (const int opacity : {1, 6, 15}) {
        const Pixels flat = blended(stack, 2, opacity);
        REQUIRE(flat.size() == 2 * behind.size());
        for (std::size_t i = 0; i < flat.size(); ++i) {
            const std::size_t at = i % behind.size();
            const bool is_second = i >= behind.size();
            for (unsigned shift = 0; shift < 32; shift += 8) {
                const auto channel = [&](const Pixels& pixels) {
                    return static_cast<int>(pixels[at] >> shift & 0xffU);
                };
                const int below = channel(is_second ? front : behind);
                const int above = channel(is_second ? behind : front);
                const int mean = (above * opacity + below * (16 - opacity) + 8) / 16;
                REQUIRE(static_cast<int>(flat[i] >> shift & 0xffU) == mean);
            }
        }
    }
}

TEST_CASE("a JPEG in full color holds colors that change from pixel to pixel") {
    Pixels stripes;
    for (int i = 0; i < width_px * height_px; ++i) {
        stripes.push_back(i % width_px % 2 == 0 ? 0xff2020c0U : 0xffc02020U);  // Red and blue.
    }
    const auto error_of = [&](JpegQuality quality) {
        return difference(stripes, decoded_jpeg(jpeg_of(width_px, height_px, stripes, quality)));
    };
    CHECK(error_of({90, true}) < 5);
    CHECK(error_of({90, false}) > 40);
}

TEST_CASE("a frame's header has its fields where the protocol puts them") {
    FrameHeader header;
    header.number = 0x01020304;
    header.revision = 77;
    header.width = 1280;
    header.height = 1024;
    header.kind = PictureKind::jpeg;
    header.quality = 80;
    header.samples = 16;
    header.flags = FrameFlag::last;
    header.machine_ms = 1.5F;
    header.digest = 0x1122334455667788U;
    header.moved_mm = 1.5;
    header.picture_bytes = 0x0102;
    header.depth_bytes = 3;
    header.pose = 0x0102;
    header.views = 2;
    header.layers = 1;
    header.opacity = 6;
    const std::string bytes = frame_header(header);
    const unsigned char expected[] = {
        'P',  '5',  'R',  'F',  4,  3, 2, 1, 77,   0,    0,    0,    0,    5,
        0,    4,    1,    80,   16, 2, 0, 0, 0xc0, 0x3f, 0x88, 0x77, 0x66, 0x55,
        0x44, 0x33, 0x22, 0x11, 0,  0, 0, 0, 0,    0,    0xf8, 0x3f, 2,    1,
        0,    0,    3,    0,    0,  0, 2, 1, 0,    0,    2,    1,    6,    0};
    REQUIRE(bytes.size() == sizeof(expected));
    CHECK(std::memcmp(bytes.data(), expected, sizeof(expected)) == 0);
    header.flags = FrameFlag::rests | FrameFlag::last;
    CHECK(frame_header(header)[19] == 3);
}

}  // namespace pxpl5::host::serve
