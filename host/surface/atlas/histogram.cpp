#include "host/surface/atlas/histogram.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <type_traits>

#include "host/volume/reduced.hpp"
#include "host/volume/typed_values.hpp"

namespace pxpl5::host {

namespace {

/// How often each of T's values occurs.
template <class T>
std::vector<std::uint64_t> count_values(std::span<const T> values) {
    std::vector<std::uint64_t> counts(std::size_t{1} << (8 * sizeof(T)));
    for (const T value : values) ++counts[static_cast<std::make_unsigned_t<T>>(value)];
    return counts;
}

template <class T>
requires std::is_integral_v<T>
void fill(std::span<const T> values, int bins, Histogram& out) {
    const auto counts = count_values(values);
    const auto value_of = [](std::size_t i) { return static_cast<double>(static_cast<T>(i)); };
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (std::size_t i = 0; i < counts.size(); ++i) {
        if (counts[i] == 0) continue;
        low = std::min(low, value_of(i));
        high = std::max(high, value_of(i));
    }
    if (low > high) return;
    out.first = low;
    out.width = std::ceil((high - low + 1) / bins);
    out.counts.resize(static_cast<std::size_t>(std::ceil((high - low + 1) / out.width)));
    for (std::size_t i = 0; i < counts.size(); ++i) {
        if (counts[i] == 0) continue;
        out.counts[static_cast<std::size_t>((value_of(i) - low) / out.width)] += counts[i];
    }
}

void fill(std::span<const float> values, int bins, Histogram& out) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const float value : values) {
        if (!std::isfinite(value)) {
            ++out.not_finite;
            continue;
        }
        low = std::min(low, static_cast<double>(value));
        high = std::max(high, static_cast<double>(value));
    }
    if (low > high) return;
    out.first = low;
    out.width = high > low ? (high - low) / bins : 1;
    out.counts.resize(high > low ? static_cast<std::size_t>(bins) : 1);
    for (const float value : values) {
        if (!std::isfinite(value)) continue;
        // The greatest value belongs to the last bin, although its upper end is no other's lower.
        const double bin = std::floor((static_cast<double>(value) - low) / out.width);
        ++out.counts[std::min(static_cast<std::size_t>(bin), out.counts.size() - 1)];
    }
}

}  // namespace

Histogram histogram(const Volume& volume, int bins) {
    assert(bins >= 1);
    assert(bins <= max_histogram_bins);
    Histogram out;
    with_values(kept(volume), [&](auto values) { fill(values, bins, out); });
    return out;
}

}  // namespace pxpl5::host
