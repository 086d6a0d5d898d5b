// A picture as encoders of video take it, and what they make of it.
#pragma once

#include <vpx/vpx_encoder.h>
#include <vpx/vpx_image.h>

#include <cstdint>
#include <span>
#include <string>

namespace pxpl5::host::film {

/// Brightness of each pixel, and two colors of each 2 x 2 pixels: those of BT.601 with 16 to 235
/// for black to white.
class VideoImage {
  public:
    /// Throws std::runtime_error without memory.
    VideoImage(int width, int height);
    ~VideoImage();
    VideoImage(const VideoImage&) = delete;
    VideoImage& operator=(const VideoImage&) = delete;

    /// rgba  width * height pixels, top row first, red in the low byte.
    void fill(std::span<const std::uint32_t> rgba);
    const vpx_image_t* get() const { return &image_; }

  private:
    vpx_image_t image_{};
};

/// An encoded picture.
struct VideoPacket {
    std::string bytes;  ///< Empty if the encoder has left the picture out.
    bool is_key = false;
};

/// Takes the encoded picture from an encoder that delays none.
VideoPacket take_packet(vpx_codec_ctx_t& codec);

}  // namespace pxpl5::host::film
