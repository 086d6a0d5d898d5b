#include "host/film/video_image.hpp"

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <stdexcept>

namespace pxpl5::host::film {

namespace {

/// Red, green and blue of a pixel, or the sums of several.
struct Color {
    int red = 0, green = 0, blue = 0;

    void add(std::uint32_t pixel) {
        red += static_cast<int>(pixel & 0xffU);
        green += static_cast<int>(pixel >> 8U & 0xffU);
        blue += static_cast<int>(pixel >> 16U & 0xffU);
    }
};

/// Rows of a plane of an image.
struct Plane {
    unsigned char* first = nullptr;
    int stride = 0;
    unsigned char* row(int y) const {
        return first + static_cast<std::ptrdiff_t>(y) * static_cast<std::ptrdiff_t>(stride);
    }
};

Plane plane_of(const vpx_image_t& image, int index) {
    return {image.planes[index], image.stride[index]};
}

// Coefficients times 256, and offsets, with a half to round. Source: ITU-R BT.601.
void fill_brightness(const std::uint32_t* pixels, int width, unsigned char* out) {
    for (int x = 0; x < width; ++x) {
        Color c;
        c.add(pixels[x]);
        out[x] = static_cast<unsigned char>(
            (66 * c.red + 129 * c.green + 25 * c.blue + (16 << 8) + 128) >> 8);
    }
}

/// below  The second of two rows.
void fill_colors(const std::uint32_t* pixels, const std::uint32_t* below, int width,
                 unsigned char* blueness, unsigned char* redness) {
    constexpr int shift = 10;  // 256, times 4 pixels.
    constexpr int offset = (128 << shift) + (1 << (shift - 1));
    const auto fill = [&](int x, int right) {
        Color c;
        for (const std::uint32_t pixel : {pixels[x], pixels[right], below[x], below[right]}) {
            c.add(pixel);
        }
        blueness[x / 2] = static_cast<unsigned char>(
            (-38 * c.red - 74 * c.green + 112 * c.blue + offset) >> shift);
        redness[x / 2] = static_cast<unsigned char>(
            (112 * c.red - 94 * c.green - 18 * c.blue + offset) >> shift);
    };
    int x = 0;
    for (; x + 1 < width; x += 2) {
        fill(x, x + 1);
    }
    if (x < width) {
        fill(x, x);
    }
}

}  // namespace

VideoImage::VideoImage(int width, int height) {
    constexpr unsigned alignment = 32;
    if (vpx_img_alloc(&image_, VPX_IMG_FMT_I420, static_cast<unsigned>(width),
                      static_cast<unsigned>(height), alignment) == nullptr) {
        throw std::runtime_error("cannot encode a video: no memory");
    }
}

VideoImage::~VideoImage() {
    vpx_img_free(&image_);
}

void VideoImage::fill(std::span<const std::uint32_t> rgba) {
    const int width = static_cast<int>(image_.d_w), height = static_cast<int>(image_.d_h);
    assert(std::ssize(rgba) == std::ptrdiff_t{width} * height);
    const Plane brightness = plane_of(image_, VPX_PLANE_Y);
    const Plane blueness = plane_of(image_, VPX_PLANE_U), redness = plane_of(image_, VPX_PLANE_V);
    const auto row = [&](int y) {
        return rgba.data() + static_cast<std::ptrdiff_t>(y) * static_cast<std::ptrdiff_t>(width);
    };
    for (int y = 0; y < height; ++y) {
        fill_brightness(row(y), width, brightness.row(y));
        if (y % 2 == 0) {
            fill_colors(row(y), row(std::min(y + 1, height - 1)), width, blueness.row(y / 2),
                        redness.row(y / 2));
        }
    }
}

VideoPacket take_packet(vpx_codec_ctx_t& codec) {
    VideoPacket packet;
    vpx_codec_iter_t next = nullptr;
    while (const vpx_codec_cx_pkt_t* part = vpx_codec_get_cx_data(&codec, &next)) {
        if (part->kind == VPX_CODEC_CX_FRAME_PKT) {
            packet.bytes.append(static_cast<const char*>(part->data.frame.buf),
                                part->data.frame.sz);
            packet.is_key = (part->data.frame.flags & VPX_FRAME_IS_KEY) != 0;
        }
    }
    return packet;
}

}  // namespace pxpl5::host::film
