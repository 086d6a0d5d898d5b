#include "host/session/transfer/picture_parts.hpp"

#include <algorithm>
#include <cassert>

#include "ringbus/rules/regions.hpp"

namespace pxpl5::host {

namespace {

std::size_t across(int length) {
    return regions_across(static_cast<std::uint32_t>(length));
}

std::size_t area(Size size) {
    return static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
}

}  // namespace

std::vector<SizedPart> parts_of(Size whole, std::size_t most_regions) {
    assert(most_regions >= 1);
    const auto side = [](std::size_t regions) {
        return static_cast<int>(regions) * static_cast<int>(region_px);
    };
    const std::size_t columns = std::min(across(whole.width), most_regions);
    const int width = side(columns);
    const int height = side(std::min(across(whole.height), most_regions / columns));
    std::vector<SizedPart> parts;
    for (int top = 0; top < whole.height; top += height) {
        for (int left = 0; left < whole.width; left += width) {
            parts.push_back(
                {{whole, left, top},
                 {std::min(width, whole.width - left), std::min(height, whole.height - top)}});
        }
    }
    return parts;
}

void put_part(const SizedPart& part, std::span<const std::uint32_t> from,
              std::span<std::uint32_t> into) {
    const auto& [place, size] = part;
    const std::size_t views = into.size() / area(place.whole);
    assert(from.size() == views * area(size));
    const auto count = [](int number) { return static_cast<std::size_t>(number); };
    for (std::size_t view = 0; view < views; ++view) {
        for (std::size_t y = 0; y < count(size.height); ++y) {
            const std::size_t row = view * count(place.whole.height) + count(place.top) + y;
            const std::size_t at = row * count(place.whole.width) + count(place.left);
            const std::size_t source = (view * count(size.height) + y) * count(size.width);
            std::ranges::copy(from.subspan(source, count(size.width)),
                              into.begin() + std::ptrdiff_t(at));
        }
    }
}

}  // namespace pxpl5::host
