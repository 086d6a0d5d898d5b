#include "host/serve/video/video_encoder.hpp"

#include <fmt/format.h>
#include <vpx/vp8cx.h>
#include <vpx/vpx_encoder.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "host/film/video_image.hpp"

namespace pxpl5::host::serve {
namespace {

constexpr int frames_per_second = 25;                          // Of the time that the encoder sees.
constexpr unsigned best_quantizer = 12, worst_quantizer = 60;  // Of 0 to 63.
constexpr int speed = -12;               // Realtime mode: -16 to 0, fast to slow.
constexpr int still_threshold = 1;       // Blocks that hardly change are not encoded.
constexpr int key_frame_percent = 400;   // Most bytes, of a frame on average.
constexpr unsigned least_kilobits = 50;  // Per second; the encoder needs some.
constexpr unsigned most_kilobits = 1'000'000;
constexpr unsigned buffer_ms = 400;      // The encoder balances frames over so long.
constexpr double worth_a_change = 0.05;  // Relative. Smaller changes of the goal are ignored.

unsigned kilobits_of(std::size_t bytes_per_frame) {
    const double kilobits = static_cast<double>(bytes_per_frame) * 8 * frames_per_second / 1000;
    return static_cast<unsigned>(std::clamp<double>(kilobits, least_kilobits, most_kilobits));
}

}  // namespace

/// libvpx's encoder for pictures of one size.
class VideoEncoder::Codec {
  public:
    Codec(int width, int height, std::size_t goal_bytes)
        : width_(width), height_(height), image_(width, height) {
        check(vpx_codec_enc_config_default(vpx_codec_vp8_cx(), &config_, 0));
        config_.g_w = static_cast<unsigned>(width);
        config_.g_h = static_cast<unsigned>(height);
        config_.g_timebase = {1, frames_per_second};
        config_.g_threads = 1;
        config_.g_lag_in_frames = 0;
        config_.g_error_resilient = 0;  // The connection loses nothing.
        config_.rc_end_usage = VPX_CBR;
        config_.rc_target_bitrate = kilobits_of(goal_bytes);
        config_.rc_dropframe_thresh = 0;
        config_.rc_buf_sz = buffer_ms;
        config_.rc_buf_initial_sz = config_.rc_buf_optimal_sz = buffer_ms / 2;
        config_.rc_min_quantizer = best_quantizer;
        config_.rc_max_quantizer = worst_quantizer;
        config_.kf_mode = VPX_KF_DISABLED;  // None but those that are asked for.
        check(vpx_codec_enc_init(&codec_, vpx_codec_vp8_cx(), &config_, 0));
        is_open_ = true;
        vpx_codec_control(&codec_, VP8E_SET_CPUUSED, speed);
        vpx_codec_control(&codec_, VP8E_SET_STATIC_THRESHOLD, still_threshold);
        vpx_codec_control(&codec_, VP8E_SET_MAX_INTRA_BITRATE_PCT, key_frame_percent);
    }
    ~Codec() { close(); }
    Codec(const Codec&) = delete;
    Codec& operator=(const Codec&) = delete;

    bool fits(int width, int height) const { return width == width_ && height == height_; }

    void aim_at(std::size_t goal_bytes) {
        const unsigned kilobits = kilobits_of(goal_bytes);
        const double change = static_cast<double>(kilobits) / config_.rc_target_bitrate - 1;
        if (std::abs(change) >= worth_a_change) {
            config_.rc_target_bitrate = kilobits;
            check(vpx_codec_enc_config_set(&codec_, &config_));
        }
    }

    Frame encode(std::span<const std::uint32_t> rgba) {
        image_.fill(rgba);
        check(vpx_codec_encode(&codec_, image_.get(), frames_, 1,
                               frames_ == 0 ? VPX_EFLAG_FORCE_KF : 0, VPX_DL_REALTIME));
        ++frames_;
        film::VideoPacket packet = film::take_packet(codec_);
        if (packet.bytes.empty()) {
            throw std::runtime_error("cannot encode a video: libvpx has left a picture out");
        }
        return {std::move(packet.bytes), packet.is_key};
    }

  private:
    void check(vpx_codec_err_t result) {
        if (result != VPX_CODEC_OK) {
            const char* detail = is_open_ ? vpx_codec_error_detail(&codec_) : nullptr;
            throw std::runtime_error(fmt::format("cannot encode a video of {} x {}: {}{}{}", width_,
                                                 height_, vpx_codec_err_to_string(result),
                                                 detail == nullptr ? "" : ": ",
                                                 detail == nullptr ? "" : detail));
        }
    }
    void close() {
        if (is_open_) {
            vpx_codec_destroy(&codec_);
        }
        is_open_ = false;
    }

    int width_, height_;
    vpx_codec_enc_cfg_t config_{};
    vpx_codec_ctx_t codec_{};
    film::VideoImage image_;
    bool is_open_ = false;
    vpx_codec_pts_t frames_ = 0;
};

VideoEncoder::VideoEncoder() = default;
VideoEncoder::~VideoEncoder() = default;

VideoEncoder::Frame VideoEncoder::encode(int width, int height, std::span<const std::uint32_t> rgba,
                                         std::size_t goal_bytes) {
    assert(rgba.size() == static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    if (std::min(width, height) < 1 || std::max(width, height) > max_video_px) {
        throw std::runtime_error(
            fmt::format("cannot encode a video of {} x {}: VP8 has 1 to {} columns and rows", width,
                        height, max_video_px));
    }
    if (!codec_ || !codec_->fits(width, height)) {
        codec_.reset();
        codec_ = std::make_unique<Codec>(width, height, goal_bytes);
    }
    codec_->aim_at(goal_bytes);
    try {
        return codec_->encode(rgba);
    } catch (...) {
        codec_.reset();  // The next picture is a key frame.
        throw;
    }
}

}  // namespace pxpl5::host::serve
