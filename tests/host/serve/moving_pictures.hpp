// Decoders of moving pictures, and how far a decoded picture is from the exact one.
#pragma once

#include <turbojpeg.h>
#include <vpx/vp8dx.h>
#include <vpx/vpx_decoder.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

namespace pxpl5::host::serve::test {

using Pixels = std::vector<std::uint32_t>;  ///< Red in the low byte, top row first.

/// libvpx's decoder. Pixels come back by the inverse of BT.601.
class VideoDecoder {
  public:
    VideoDecoder() {
        if (vpx_codec_dec_init(&codec_, vpx_codec_vp8_dx(), nullptr, 0) != VPX_CODEC_OK) {
            throw std::runtime_error("libvpx: no decoder");
        }
    }
    ~VideoDecoder() { vpx_codec_destroy(&codec_); }
    VideoDecoder(const VideoDecoder&) = delete;
    VideoDecoder& operator=(const VideoDecoder&) = delete;

    /// The picture, at once; empty if it cannot be decoded.
    Pixels decode(const std::string& bytes) {
        if (vpx_codec_decode(&codec_, reinterpret_cast<const std::uint8_t*>(bytes.data()),
                             static_cast<unsigned>(bytes.size()), nullptr, 0) != VPX_CODEC_OK) {
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

    int width = 0, height = 0;  ///< Size of the last picture.

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

/// The pixels of a JPEG of that size. Throws std::runtime_error if it cannot be decoded.
inline Pixels decoded_jpeg(const std::string& bytes, int width, int height) {
    tjhandle decoder = tjInitDecompress();
    Pixels pixels(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    const int failed = tjDecompress2(decoder, reinterpret_cast<const unsigned char*>(bytes.data()),
                                     bytes.size(), reinterpret_cast<unsigned char*>(pixels.data()),
                                     width, 0, height, TJPF_RGBX, 0);
    tjDestroy(decoder);
    if (failed != 0) {
        throw std::runtime_error("libjpeg-turbo: not a JPEG");
    }
    return pixels;
}

/// Mean squared difference of red, green and blue. Both pictures have the same size.
inline double mean_square(const Pixels& a, const Pixels& b) {
    if (a.size() != b.size()) {
        throw std::runtime_error("pictures of different sizes");
    }
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        for (const unsigned shift : {0U, 8U, 16U}) {
            const int d =
                static_cast<int>(a[i] >> shift & 0xffU) - static_cast<int>(b[i] >> shift & 0xffU);
            sum += d * d;
        }
    }
    return sum / static_cast<double>(a.size() * 3);
}

/// Peak signal-to-noise ratio of red, green and blue, in dB; at most 100.
inline double psnr(const Pixels& a, const Pixels& b) {
    return 10 * std::log10(255.0 * 255.0 / std::max(mean_square(a, b), 6.5e-6));
}

}  // namespace pxpl5::host::serve::test
