#include "host/serve/server/link_rate.hpp"

#include <algorithm>
#include <array>

namespace pxpl5::host::serve {
namespace {

constexpr std::size_t kept_pings = 60;
constexpr double forgetting = 0.8;      // Weight of the previous estimate at a new measurement.
constexpr double least_time_ms = 0.05;  // Resolution of the clock; keeps a rate finite.
constexpr double longest_ms = 1000;     // A hidden tab displays no frames for minutes.
constexpr double margin = 0.8;          // To improve, a frame must fit this part of the budget.

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

void LinkRate::sent(std::uint32_t number, std::size_t bytes, double now_ms) {
    flying_.push_back({number, bytes, now_ms});
    last_sent_ = number;
}

void LinkRate::shown(std::uint32_t number, double now_ms) {
    if (flying_.empty() || number < flying_.front().number || number > last_sent_) {
        return;
    }
    const double latency_ms = rtts_ms_.empty() ? 0 : *std::ranges::min_element(rtts_ms_);
    const double begun_ms = std::max(flying_.front().sent_ms + latency_ms, last_shown_ms_);
    double bytes = 0;
    while (!flying_.empty() && flying_.front().number <= number) {
        bytes += static_cast<double>(flying_.front().bytes);
        flying_.pop_front();
    }
    recent_bytes_ = recent_bytes_ * forgetting + bytes;
    recent_ms_ = recent_ms_ * forgetting + std::clamp(now_ms - begun_ms, least_time_ms, longest_ms);
    last_shown_ms_ = now_ms;
}

double LinkRate::bytes_per_s() const {
    return recent_ms_ > 0 ? recent_bytes_ / recent_ms_ * 1000 : 0;
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
    while (step_ > 0 && bytes_of(step_, count) > budget_bytes()) {
        --step_;
    }
    // One step at a time, and with room to spare, so that it does not swing.
    if (step_ + 1 < steps.size() && bytes_of(step_ + 1, count) < margin * budget_bytes()) {
        ++step_;
    }
    return steps[step_].quality;
}

double LinkRate::scale(std::size_t full_pixels) {
    if (bytes_per_s() == 0 || bytes_per_pixel_ == 0) {
        return scale_;
    }
    const auto bytes_at = [&](double scale) {
        return bytes_of(0, static_cast<double>(full_pixels) * scale * scale);
    };
    constexpr double step = 0.25, least = 0.5;
    while (scale_ > least && bytes_at(scale_) > budget_bytes()) {
        scale_ -= step;
    }
    if (scale_ < 1 && bytes_at(scale_ + step) < margin * budget_bytes()) {
        scale_ += step;
    }
    return scale_;
}

}  // namespace pxpl5::host::serve
