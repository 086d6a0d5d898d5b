#include "host/serve/link_rate.hpp"

#include <algorithm>
#include <array>

namespace pxpl5::host::serve {
namespace {

constexpr std::size_t kKeptPings = 12;
constexpr double kForget = 0.8;        // Weight of what was known when something new is measured.
constexpr double kLeastTimeMs = 0.05;  // The clock's doubt; keeps a rate finite.
constexpr double kMargin = 0.8;        // To improve, a frame must fit this part of the budget.

/// Size of a JPEG against one of kMinQuality, by steps of quality: of pictures of the phantoms.
constexpr std::array<double, 5> kSizes{1.0, 1.10, 1.26, 1.52, 2.10};

double size_of(int quality) {
    return kSizes[static_cast<std::size_t>((quality - kMinQuality) / kQualityStep)];
}

}  // namespace

void LinkRate::pinged(double rtt_ms) {
    rtts_ms_.push_back(rtt_ms);
    if (rtts_ms_.size() > kKeptPings) rtts_ms_.pop_front();
}

void LinkRate::sent(std::uint32_t number, std::size_t bytes, double now_ms) {
    flying_.push_back({number, bytes, now_ms});
    last_sent_ = number;
}

void LinkRate::shown(std::uint32_t number, double now_ms) {
    if (flying_.empty() || number < flying_.front().number || number > last_sent_) return;
    const double latency_ms = rtts_ms_.empty() ? 0 : *std::ranges::min_element(rtts_ms_);
    const double begun_ms = std::max(flying_.front().sent_ms + latency_ms, last_shown_ms_);
    double bytes = 0;
    while (!flying_.empty() && flying_.front().number <= number) {
        bytes += static_cast<double>(flying_.front().bytes);
        flying_.pop_front();
    }
    recent_bytes_ = recent_bytes_ * kForget + bytes;
    recent_ms_ = recent_ms_ * kForget + std::max(now_ms - begun_ms, kLeastTimeMs);
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
    if (bytes_per_s() == 0 || bytes_per_pixel_ == 0) return quality_;
    const auto count = static_cast<double>(pixels);
    while (quality_ > kMinQuality && bytes_of(quality_, count) > budget_bytes()) {
        quality_ -= kQualityStep;
    }
    // One step at a time, and with room to spare, so that it does not swing.
    if (quality_ < kMaxQuality &&
        bytes_of(quality_ + kQualityStep, count) < kMargin * budget_bytes()) {
        quality_ += kQualityStep;
    }
    return quality_;
}

double LinkRate::scale(std::size_t full_pixels) {
    if (bytes_per_s() == 0 || bytes_per_pixel_ == 0) return scale_;
    const auto bytes_at = [&](double scale) {
        return bytes_of(kMinQuality, static_cast<double>(full_pixels) * scale * scale);
    };
    constexpr double kStep = 0.25, kLeast = 0.5;
    while (scale_ > kLeast && bytes_at(scale_) > budget_bytes()) scale_ -= kStep;
    if (scale_ < 1 && bytes_at(scale_ + kStep) < kMargin * budget_bytes()) scale_ += kStep;
    return scale_;
}

}  // namespace pxpl5::host::serve
