// Measures the data rate of a viewer's connection, and derives the quality.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>

#include "host/serve/encoding/encode.hpp"

namespace pxpl5::host::serve {

inline constexpr double goal_frames_per_second = 25;
/// Qualities of moving frames, as JPEG: least_quality, then 60, 70, 80 and 90, then best_quality.
inline constexpr JpegQuality least_quality{50, false}, best_quality{90, true};
/// Faster links get no video: JPEG is faster to encode, and one encoding serves all viewers.
inline constexpr double max_video_bytes_per_s = 20e6 / 8;

/// Measures a link from acknowledgements. A frame of B bytes, sent at s and acknowledged at a, was
/// on its way for latency + B / rate, or followed the frame before it out of the same pipe:
///
///     B / rate = a - max(s + latency, a of the frame before)
///
/// but 1 s at most: what takes longer is a tab that is hidden, or a link for which the least
/// quality is too much anyhow. The latency is that of pings, the least of the last five minutes.
/// Source: ours, after BBR (Cardwell et al. 2016), which looks at rate and latency apart because no
/// single packet shows both. All times are milliseconds of one clock that never goes back.
class LinkRate {
  public:
    /// A ping came back after `rtt_ms`.
    void pinged(double rtt_ms);
    /// A frame has been handed to the connection; numbers count up by 1.
    void sent(std::uint32_t number, std::size_t bytes, double now_ms,
              PictureKind kind = PictureKind::jpeg);
    /// The viewer has displayed frame `number` and with it all before, so long after it arrived.
    /// Numbers that were never sent, or are known already, change nothing.
    void shown(std::uint32_t number, double now_ms, double since_arrival_ms = 0);

    std::size_t unacknowledged() const { return flying_.size(); }
    /// Whether the oldest frame under way has not been displayed for more than 2 s.
    bool is_stalled(double now_ms) const;
    /// Bytes a second until they are displayed; 0 while nothing is known.
    double bytes_per_s() const { return to_screen_.bytes_per_s(); }

    /// Whether the next moving frame is a video frame: the viewer takes video, the link is slow,
    /// and a JPEG of quality 90 and of `full_pixels` is too large for it. The link gets JPEG again
    /// only after a resting picture, because large pictures measure a link best.
    bool uses_video(std::size_t full_pixels, bool takes_video);
    /// Bytes that a video frame may have, with its depths.
    std::size_t video_bytes() const;

    /// Records the size of a moving JPEG, for quality(), uses_video() and scale().
    void encoded(JpegQuality quality, std::size_t pixels, std::size_t bytes);
    /// Records the size of the depths of a moving video frame, for scale().
    void encoded_depths(std::size_t pixels, std::size_t bytes);
    /// The quality of the next moving frame of that size: least_quality to best_quality.
    JpegQuality quality(std::size_t pixels);
    /// 1, 3/4 or 1/2: how much smaller than `full_pixels` a frame must be to move.
    double scale(std::size_t full_pixels);

  private:
    struct Flying {
        std::uint32_t number = 0;
        std::size_t bytes = 0;
        double sent_ms = 0;
        PictureKind kind = PictureKind::jpeg;
    };
    /// Each measurement lowers the weight of older ones to 0.8.
    struct Rate {
        double bytes = 0, ms = 0;
        void add(double more_bytes, double more_ms);
        double bytes_per_s() const { return ms > 0 ? bytes / ms * 1000 : 0; }
        double budget_bytes() const { return bytes_per_s() / goal_frames_per_second; }
    };
    double bytes_of(std::size_t step, double pixels) const;

    std::deque<Flying> flying_;
    std::deque<double> rtts_ms_;
    std::uint32_t last_sent_ = 0;
    PictureKind last_kind_ = PictureKind::jpeg;
    double last_shown_ms_ = 0, last_arrived_ms_ = 0;
    Rate to_screen_, to_viewer_;
    double bytes_per_pixel_ = 0;  // At least_quality.
    std::size_t step_ = 3;        // Of the qualities.
    double scale_ = 1;
    bool is_video_ = false;
    double depth_bytes_per_pixel_ = 0;  // With video.
};

}  // namespace pxpl5::host::serve
