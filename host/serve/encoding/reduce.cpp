#include "host/serve/encoding/reduce.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <iterator>

namespace pxpl5::host::serve {
namespace {

constexpr int smallest_px = 64;
constexpr std::size_t channels = 4;
constexpr unsigned channel_bits = 8;
constexpr std::uint32_t channel_mask = 0xff;

/// The part of an old pixel that a new pixel covers, in units of 1 / (length of the new side) of an
/// old pixel. The parts of a new pixel add up to the length of the old side.
struct Part {
    std::size_t old_at = 0, new_at = 0;
    std::uint64_t weight = 0;
};

/// The parts along a side, in order.
std::vector<Part> parts_of(int old_px, int new_px) {
    const auto old_count = static_cast<std::size_t>(old_px);
    const auto new_count = static_cast<std::size_t>(new_px);
    std::vector<Part> parts;
    parts.reserve(old_count + new_count);
    std::size_t begin = 0;  // Of the part, of old_count * new_count units.
    while (begin < old_count * new_count) {
        const std::size_t old_at = begin / new_count, new_at = begin / old_count;
        const std::size_t end = std::min((old_at + 1) * new_count, (new_at + 1) * old_count);
        parts.push_back({old_at, new_at, end - begin});
        begin = end;
    }
    return parts;
}

void check([[maybe_unused]] std::span<const std::uint32_t> words, [[maybe_unused]] const Size& from,
           [[maybe_unused]] const Size& to, [[maybe_unused]] int pictures) {
    assert(0 < to.width && to.width <= from.width && 0 < to.height && to.height <= from.height);
    assert(words.size() == static_cast<std::size_t>(from.width) *
                               static_cast<std::size_t>(from.height) *
                               static_cast<std::size_t>(pictures));
}

/// Sums of the channels of a new row.
using Sums = std::vector<std::array<std::uint64_t, channels>>;

void add_row(Sums& sums, std::span<const std::uint32_t> row, const std::vector<Part>& columns,
             std::uint64_t weight) {
    for (const Part& part : columns) {
        const std::uint32_t pixel = row[part.old_at];
        const std::uint64_t share = part.weight * weight;
        auto& sum = sums[part.new_at];
        for (std::size_t channel = 0; channel < channels; ++channel) {
            sum[channel] += share * (pixel >> (channel * channel_bits) & channel_mask);
        }
    }
}

std::uint32_t mean(const std::array<std::uint64_t, channels>& sum, std::uint64_t area) {
    std::uint32_t pixel = 0;
    for (std::size_t channel = 0; channel < channels; ++channel) {
        const auto value = static_cast<std::uint32_t>((sum[channel] + area / 2) / area);
        pixel |= value << (channel * channel_bits);
    }
    return pixel;
}

}  // namespace

Size moving_size(const Size& full, double scale) {
    const auto side = [scale](int px) {
        return std::max(std::min(px, smallest_px), static_cast<int>(std::lround(px * scale)));
    };
    return {side(full.width), side(full.height)};
}

std::vector<std::uint32_t> reduced_pixels(std::span<const std::uint32_t> rgba, const Size& from,
                                          const Size& to, int pictures) {
    check(rgba, from, to, pictures);
    const std::vector<Part> columns = parts_of(from.width, to.width);
    const std::vector<Part> rows = parts_of(from.height, to.height);
    const auto old_width = static_cast<std::size_t>(from.width);
    const auto old_pixels = old_width * static_cast<std::size_t>(from.height);
    const auto area = static_cast<std::uint64_t>(old_pixels);  // Sum of the weights.
    std::vector<std::uint32_t> reduced;
    reduced.reserve(static_cast<std::size_t>(to.width) * static_cast<std::size_t>(to.height) *
                    static_cast<std::size_t>(pictures));
    Sums sums(static_cast<std::size_t>(to.width));
    for (std::size_t first = 0; first < rgba.size(); first += old_pixels) {
        for (auto part = rows.begin(); part != rows.end();) {
            std::ranges::fill(sums, Sums::value_type{});
            const std::size_t row = part->new_at;
            for (; part != rows.end() && part->new_at == row; ++part) {
                add_row(sums, rgba.subspan(first + part->old_at * old_width, old_width), columns,
                        part->weight);
            }
            std::ranges::transform(sums, std::back_inserter(reduced),
                                   [area](const auto& sum) { return mean(sum, area); });
        }
    }
    return reduced;
}

std::vector<std::uint32_t> reduced_depths(std::span<const std::uint32_t> depths, const Size& from,
                                          const Size& to, int pictures) {
    check(depths, from, to, pictures);
    const auto middle = [](int at, int old_px, int new_px) {
        return static_cast<std::size_t>((2LL * at + 1) * old_px / (2LL * new_px));
    };
    const auto old_width = static_cast<std::size_t>(from.width);
    const auto old_pixels = old_width * static_cast<std::size_t>(from.height);
    std::vector<std::uint32_t> reduced;
    reduced.reserve(static_cast<std::size_t>(to.width) * static_cast<std::size_t>(to.height) *
                    static_cast<std::size_t>(pictures));
    for (std::size_t first = 0; first < depths.size(); first += old_pixels) {
        for (int y = 0; y < to.height; ++y) {
            const auto row =
                depths.subspan(first + middle(y, from.height, to.height) * old_width, old_width);
            for (int x = 0; x < to.width; ++x) {
                reduced.push_back(row[middle(x, from.width, to.width)]);
            }
        }
    }
    return reduced;
}

}  // namespace pxpl5::host::serve
