#include "host/base/chart_axis.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>

namespace pxpl5::host {

namespace {

/// The least of 1, 2, 5 times a power of ten that is not below `step`.
double round_up(double step) {
    const double power = std::pow(10.0, std::floor(std::log10(step)));
    for (const double factor : {1.0, 2.0, 5.0}) {
        if (factor * power >= step * (1 - 1e-9)) {
            return factor * power;
        }
    }
    return 10 * power;
}

/// Multiples of `step` in [low, high].
std::vector<double> multiples(double low, double high, double step) {
    std::vector<double> ticks;
    const double first = std::ceil(low / step - 1e-9), last = std::floor(high / step + 1e-9);
    for (double count = first; count <= last; ++count) {
        ticks.push_back(count * step + 0.0);  // No negative zero.
    }
    return ticks;
}

}  // namespace

double ChartAxis::place(double value) const {
    if (logarithmic) {
        const double part = std::log(std::max(value, low) / low) / std::log(high / low);
        return std::clamp(part, 0.0, 1.0);
    }
    return std::clamp((value - low) / (high - low), 0.0, 1.0);
}

ChartAxis linear_axis(double low, double high, int most_ticks) {
    assert(low < high);
    assert(most_ticks > 1);
    const double step = round_up((high - low) / (most_ticks - 1));
    return {low, high, false, multiples(low, high, step)};
}

ChartAxis axis_from_zero(double highest, int most_ticks) {
    assert(most_ticks > 1);
    const double top = highest > 0 ? highest : 1;
    const double step = round_up(top / (most_ticks - 1));
    const double high = step * std::ceil(top / step - 1e-9);
    return {0, high, false, multiples(0, high, step)};
}

ChartAxis logarithmic_axis(double lowest, double highest, int most_ticks) {
    assert(lowest > 0);
    assert(most_ticks > 1);
    ChartAxis axis{lowest / 1.4, std::max(highest, lowest * 10) * 1.4, true, {}};
    const double first = std::ceil(std::log10(axis.low)), last = std::floor(std::log10(axis.high));
    const double step = std::ceil((last - first + 1) / most_ticks);
    for (double decade = first; decade <= last; decade += step) {
        axis.ticks.push_back(std::pow(10.0, decade));
    }
    return axis;
}

ChartAxis octave_axis(double lowest, double highest, int most_ticks) {
    assert(lowest > 0);
    assert(most_ticks > 1);
    const double first = std::floor(std::log2(lowest) + 1e-9);
    const double last = std::max(std::ceil(std::log2(highest) - 1e-9), first + 1);
    ChartAxis axis{std::exp2(first), std::exp2(last), true, {}};
    const double step = std::ceil((last - first + 1) / most_ticks);
    for (double octave = first; octave <= last; octave += step) {
        axis.ticks.push_back(std::exp2(octave));
    }
    return axis;
}

std::string grouped(double value) {
    const std::string plain = std::abs(value) >= 1e6 || value == std::round(value)
                                  ? fmt::format("{:.0f}", value)
                                  : fmt::format("{:.6g}", value);
    const std::size_t start = plain.starts_with('-') ? 1 : 0;
    std::size_t point = plain.find_first_not_of("0123456789", start);
    point = point == std::string::npos ? plain.size() : point;
    std::string text = plain.substr(0, start);
    for (std::size_t index = start; index < point; ++index) {
        if (index > start && (point - index) % 3 == 0) {
            text += ',';
        }
        text += plain[index];
    }
    return text + plain.substr(point);
}

std::string counted(std::uint64_t n, std::string_view word) {
    return fmt::format("{} {}{}", grouped(static_cast<double>(n)), word, n == 1 ? "" : "s");
}

}  // namespace pxpl5::host
