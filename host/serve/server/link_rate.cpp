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

/// Size of a JPEG against one of min_quality, by steps of quality: of pictures of the phantoms.
constexpr std::array<double, 5> relative_sizes{1.0, 1.10, 1.26, 1.52, 2.10};

double size_of(int quality) {
    return relative_sizes[static_cast<std::size_t>((quality - min_quality) / quality_step)];
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

void LinkRate::encoded(int quality, std::size_t pixels, std::size_t bytes) {
    bytes_per_pixel_ = static_cast<double>(bytes) / static_cast<double>(pixels) / size_of(quality);
}

double LinkRate::bytes_of(int quality, double pixels) const {
    return bytes_per_pixel_ * size_of(quality) * pixels;
}

int LinkRate::quality(std::size_t pixels) {
    if (bytes_per_s() == 0 || bytes_per_pixel_ == 0) {
        return quality_;
    }
    const auto count = static_cast<double>(pixels);
    while (quality_ > min_quality && bytes_of(quality_, count) > budget_bytes()) {
        quality_ -= quality_step;
    }
    // One step at a time, and with room to spare, so that it does not swing.
    if (quality_ < max_quality &&
        bytes_of(quality_ + quality_step, count) < margin * budget_bytes()) {
        quality_ += quality_step;
    }
    return quality_;
}

double LinkRate::scale(std::size_t full_pixels) {
    if (bytes_per_s() == 0 || bytes_per_pixel_ == 0) {
        return scale_;
    }
    const auto bytes_at = [&](double scale) {
        return bytes_of(min_quality, static_cast<double>(full_pixels) * scale * scale);
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
