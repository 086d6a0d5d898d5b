// The moving pictures of one viewer as a video.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

namespace pxpl5::host::serve {

inline constexpr int max_video_px = 16383;  ///< Per side. Source: RFC 6386, 9.1.

/// Encodes pictures as VP8 (RFC 6386), each at once: no picture waits for a later one. A picture
/// depends on the pictures before it, unless it is a key frame. Colors are those of BT.601 with 16
/// to 235 for black to white; each 2 x 2 pixels share one color.
class VideoEncoder {
  public:
    struct Frame {
        std::string bytes;
        bool is_key = false;
    };

    VideoEncoder();
    ~VideoEncoder();
    VideoEncoder(const VideoEncoder&) = delete;
    VideoEncoder& operator=(const VideoEncoder&) = delete;

    /// Encodes the next picture. The first picture is a key frame, and so is each picture after a
    /// change of the size.
    ///
    /// rgba        width * height pixels, top row first, red in the low byte; 1 to max_video_px
    ///             columns and rows.
    /// goal_bytes  Size of a frame on average. Frames may be smaller, because there is a best
    ///             quality, or larger, because there is a worst. A key frame may have 4 times as
    ///             many.
    ///
    /// Throws std::runtime_error with the encoder's reason.
    Frame encode(int width, int height, std::span<const std::uint32_t> rgba,
                 std::size_t goal_bytes);

  private:
    class Codec;
    std::unique_ptr<Codec> codec_;  ///< For one size.
};

}  // namespace pxpl5::host::serve
