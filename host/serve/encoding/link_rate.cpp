#include "host/serve/encoding/link_rate.hpp"

#include <algorithm>
#include <array>

namespace pxpl5::host::serve {
namespace {

constexpr std::size_t kept_pings = 60;
constexpr double forgetting = 0.8;      // Weight of the previous estimate at a new measurement.
constexpr double least_time_ms = 0.05;  // Resolution of the clock; keeps a rate finite.
constexpr double longest_ms = 1000;     // A hidden tab displays no frames for minutes.
constexpr double stalled_ms = 2000;
constexpr double margin = 0.8;  // To improve, a frame must fit this part of the budget.

struct Step {
    JpegQuality quality;
    double size;  ///< Relative to least_quality, for pictures of the phantoms.
};
constexpr std::array<Step, 6> steps{{{least_quality, 1.0},
                                     {{60, false}, 1.10},
                                     {{70, false}, 1.26},
                                     {{80, false}, 1.52},
                                     {{90, false}, 2.10},
                                     {best_quality, 3.23}}};

constexpr std::size_t video_below_step = 4;  // JPEG of quality 90.
/// With fewer, blocks are seen: 28 dB for pictures of the phantoms.
constexpr double least_video_bytes_per_pixel = 0.015;

double size_of(JpegQuality quality) {
    return std::ranges::find(steps, quality, &Step::quality)->size;
}

}  // namespace

void LinkRate::pinged(double rtt_ms) {
    rtts_ms_.push_back(rtt_ms);
    if (rtts_ms_.size() > kept_pings) {
        rtts_ms_.pop_front();
    }
}

void LinkRate::sent(std::uint32_t number, std::size_t bytes, double now_ms, PictureKind kind) {
    flying_.push_back({number, bytes, now_ms, kind});
    last_sent_ = number;
    last_kind_ = kind;
}

void LinkRate::Rate::add(double more_bytes, double more_ms) {
    bytes = bytes * forgetting + more_bytes;
    ms = ms * forgetting + std::clamp(more_ms, least_time_ms, longest_ms);
}

void LinkRate::shown(std::uint32_t number, double now_ms, double since_arrival_ms) {
    if (flying_.empty() || number < flying_.front().number || number > last_sent_) {
        return;
    }
    const double latency_ms = rtts_ms_.empty() ? 0 : *std::ranges::min_element(rtts_ms_);
    const double earliest_ms = flying_.front().sent_ms + latency_ms;
    double bytes = 0;
    bool is_video = true;
    while (!flying_.empty() && flying_.front().number <= number) {
        bytes += static_cast<double>(flying_.front().bytes);
        is_video = is_video && flying_.front().kind == PictureKind::vp8;
        flying_.pop_front();
    }
    const double arrived_ms = now_ms - std::max(since_arrival_ms, 0.0);
    const double link_ms = arrived_ms - std::max(earliest_ms, last_arrived_ms_);
    // A small frame that arrives in time may have waited for anything but the link.
    const bool is_in_time = link_ms <= 1000 / goal_frames_per_second;
    if (!is_video || !is_in_time || bytes / link_ms * 1000 > to_viewer_.bytes_per_s()) {
        to_viewer_.add(bytes, link_ms);
    }
    if (!is_video) {
        to_screen_.add(bytes, now_ms - std::max(earliest_ms, last_shown_ms_));
    }
    last_arrived_ms_ = std::max(last_arrived_ms_, arrived_ms);
    last_shown_ms_ = now_ms;
}

bool LinkRate::is_stalled(double now_ms) const {
    return !flying_.empty() &&
           now_ms - std::max(flying_.front().sent_ms, last_shown_ms_) > stalled_ms;
}

bool LinkRate::uses_video(std::size_t full_pixels, bool takes_video) {
    const double rate = to_viewer_.bytes_per_s(), budget = to_viewer_.budget_bytes();
    const bool is_known = rate > 0 && bytes_per_pixel_ > 0;
    const double jpeg_bytes = bytes_of(video_below_step, static_cast<double>(full_pixels));
    if (!takes_video || !is_known) {
        is_video_ = false;
    } else if (!is_video_) {
        is_video_ = rate < max_video_bytes_per_s && jpeg_bytes > budget;
    } else if (last_kind_ == PictureKind::png) {
        is_video_ = margin * rate < max_video_bytes_per_s && jpeg_bytes > margin * budget;
    }
    return is_video_;
}

std::size_t LinkRate::video_bytes() const {
    return static_cast<std::size_t>(margin * to_viewer_.budget_bytes());
}

void LinkRate::encoded_depths(std::size_t pixels, std::size_t bytes) {
    depth_bytes_per_pixel_ = static_cast<double>(bytes) / static_cast<double>(pixels);
}

void LinkRate::encoded(JpegQuality quality, std::size_t pixels, std::size_t bytes) {
    bytes_per_pixel_ = static_cast<double>(bytes) / static_cast<double>(pixels) / size_of(quality);
}

double LinkRate::bytes_of(std::size_t step, double pixels) const {
    return bytes_per_pixel_ * steps[step].size * pixels;
}

JpegQuality LinkRate::quality(std::size_t pixels) {
    if (bytes_per_s() == 0 || bytes_per_pixel_ == 0) {
        return steps[step_].quality;
    }
    const auto count = static_cast<double>(pixels);
    while (step_ > 0 && bytes_of(step_, count) > to_screen_.budget_bytes()) {
        --step_;
    }
    // One step at a time, and with room to spare, so that it does not swing.
    if (step_ + 1 < steps.size() &&
        bytes_of(step_ + 1, count) < margin * to_screen_.budget_bytes()) {
        ++step_;
    }
    return steps[step_].quality;
}

double LinkRate::scale(std::size_t full_pixels) {
    if (bytes_per_s() == 0 || bytes_per_pixel_ == 0) {
        return scale_;
    }
    const auto bytes_at = [&](double scale) {
        const double pixels = static_cast<double>(full_pixels) * scale * scale;
        return is_video_ ? (least_video_bytes_per_pixel + depth_bytes_per_pixel_) * pixels
                         : bytes_of(0, pixels);
    };
    const double budget = (is_video_ ? to_viewer_ : to_screen_).budget_bytes();
    constexpr double step = 0.25, least = 0.5;
    while (scale_ > least && bytes_at(scale_) > budget) {
        scale_ -= step;
    }
    if (scale_ < 1 && bytes_at(scale_ + step) < margin * budget) {
        scale_ += step;
    }
    return scale_;
}

}  // namespace pxpl5::host::serve
