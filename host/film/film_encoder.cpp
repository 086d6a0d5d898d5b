#include "host/film/film_encoder.hpp"

#include <fmt/format.h>
#include <vpx/vp8cx.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace pxpl5::host::film {

namespace {

constexpr unsigned quality = 8;              // Quantizer, of 0 (best) to 63.
constexpr int speed = 3;                     // 0 (slow and small) to 16.
constexpr unsigned most_kilobits = 200'000;  // Per second: the quality decides.
constexpr double key_frame_s = 2;            // A player seeks to key frames.

}  // namespace

FilmEncoder::FilmEncoder(const FilmForm& form) : image_(form.width, form.height) {
    check(vpx_codec_enc_config_default(vpx_codec_vp8_cx(), &config_, 0));
    config_.g_w = static_cast<unsigned>(form.width);
    config_.g_h = static_cast<unsigned>(form.height);
    config_.g_timebase = {1, ticks_per_second};
    config_.g_threads = 1;        // The same bytes on each computer.
    config_.g_lag_in_frames = 0;  // Each picture gives one packet.
    config_.rc_end_usage = VPX_Q;
    config_.rc_target_bitrate = most_kilobits;
    config_.rc_min_quantizer = quality;
    config_.rc_max_quantizer = quality;
    config_.rc_dropframe_thresh = 0;
    config_.kf_max_dist =
        static_cast<unsigned>(std::lround(std::max(1.0, key_frame_s * form.rate)));
    check(vpx_codec_enc_init(&codec_, vpx_codec_vp8_cx(), &config_, 0));
    vpx_codec_control(&codec_, VP8E_SET_CPUUSED, speed);
    vpx_codec_control(&codec_, VP8E_SET_CQ_LEVEL, quality);
}

FilmEncoder::~FilmEncoder() {
    vpx_codec_destroy(&codec_);
}

VideoPacket FilmEncoder::encode(std::span<const std::uint32_t> rgba, std::int64_t begin,
                                std::int64_t duration) {
    image_.fill(rgba);
    check(vpx_codec_encode(&codec_, image_.get(), begin, static_cast<unsigned long>(duration), 0,
                           VPX_DL_GOOD_QUALITY));
    VideoPacket packet = take_packet(codec_);
    if (packet.bytes.empty()) {
        throw std::runtime_error("libvpx has left a picture out");
    }
    return packet;
}

void FilmEncoder::check(vpx_codec_err_t result) {
    if (result != VPX_CODEC_OK) {
        throw std::runtime_error(fmt::format("libvpx cannot encode {} x {} pixels: {}", config_.g_w,
                                             config_.g_h, vpx_codec_err_to_string(result)));
    }
}

}  // namespace pxpl5::host::film
