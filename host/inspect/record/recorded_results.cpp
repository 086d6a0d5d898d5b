#include "host/inspect/record/recorded_results.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "host/base/digest.hpp"
#include "isa/contract/region_layout.hpp"
#include "ringbus/rules/views.hpp"

namespace pxpl5::host::inspect {

namespace {

namespace schema = bus::schema;

constexpr std::size_t tile_pixels = region_pixels;
constexpr std::uint32_t color_mask = 0xFFFFFF;

std::size_t in_tile(int x, int y) {
    return static_cast<std::size_t>(y * region_px + x);
}

/// Calls visit(x, y in the region, x, y in the picture) row by row until it is false.
template <typename Visit>
void each_pixel(const RecordedFrame& frame, std::uint32_t region, const Visit& visit) {
    const RegionPlace place = frame.place(region);
    const int width = static_cast<int>(frame.draw().width());
    const int bottom = (place.view + 1) * static_cast<int>(frame.draw().height());
    for (int y = 0; y < region_px && place.y0_px + y < bottom; ++y) {
        for (int x = 0; x < region_px && place.x0_px + x < width; ++x) {
            if (!visit(x, y, place.x0_px + x, place.y0_px + y)) {
                return;
            }
        }
    }
}

/// The region, if the message has it.
std::optional<RecordedTile> tile_in(const schema::RegionPixels& sent, std::uint32_t region) {
    std::size_t before = 0, depths_before = 0;
    for (const schema::RegionTile* tile : *sent.tiles()) {
        if (tile->region() == region) {
            const auto part_of = [](const flatbuffers::Vector<std::uint32_t>* words,
                                    std::size_t regions) {
                return words == nullptr || words->size() == 0
                           ? std::span<const std::uint32_t>()
                           : std::span(words->data() + regions * region_pixels, region_pixels);
            };
            return RecordedTile{part_of(sent.pixels(), before),
                                tile->has_depths() ? part_of(sent.depths(), depths_before)
                                                   : std::span<const std::uint32_t>(),
                                {tile->instructions(), tile->cycles()}};
        }
        before += 1;
        depths_before += tile->has_depths() ? 1 : 0;
    }
    return std::nullopt;
}

std::span<const std::uint32_t> pixels_in(const bus::Message& done) {
    const auto* pixels = done.as<schema::FrameDone>()->pixels();
    return pixels == nullptr ? std::span<const std::uint32_t>()
                             : std::span<const std::uint32_t>(pixels->data(), pixels->size());
}

}  // namespace

std::optional<RecordedTile> tile_of(const RecordedFrame& frame, std::uint32_t region) {
    for (const auto& [renderer, message] : frame.pixels) {
        if (const auto tile = tile_in(*message.as<schema::RegionPixels>(), region)) {
            return tile;
        }
    }
    return std::nullopt;
}

FrameShape shape_of(const RecordedFrame& frame) {
    const schema::DrawFrame& draw = frame.draw();
    return {static_cast<int>(draw.width()), static_cast<int>(draw.height()),
            static_cast<int>(draw.views()->size())};
}

std::vector<std::uint32_t> joined_picture(const RecordedFrame& frame) {
    std::vector<std::uint32_t> joined;
    if (frame.done.size() < 2) {
        return joined;
    }
    const auto views = static_cast<std::size_t>(shape_of(frame).views);
    for (std::size_t view = 0; view < views; ++view) {
        const std::size_t buffer = frame_buffer_of(view, frame.done.size());
        const std::span<const std::uint32_t> stack = pixels_in(frame.done[buffer]);
        const std::size_t pixels = stack.size() / views_of(views, buffer, frame.done.size());
        const auto own = stack.subspan(view_place(view, frame.done.size()) * pixels, pixels);
        joined.insert(joined.end(), own.begin(), own.end());
    }
    return joined;
}

std::span<const std::uint32_t> picture_of(const RecordedFrame& frame) {
    const std::span<const std::uint32_t> picture =
        frame.done.size() == 1 ? pixels_in(frame.done.front()) : frame.joined;
    return picture.size() == shape_of(frame).pixels() ? picture : std::span<const std::uint32_t>();
}

std::uint64_t digest_of(std::span<const std::uint32_t> picture) {
    Digest digest;
    digest.add(std::as_bytes(picture));
    return digest.value();
}

std::vector<std::uint32_t> cut_out(const RecordedFrame& frame, std::uint32_t region,
                                   std::span<const std::uint32_t> picture) {
    std::vector<std::uint32_t> tile(region_pixels);
    const auto width = static_cast<std::size_t>(frame.draw().width());
    each_pixel(frame, region, [&](int x, int y, int px, int py) {
        tile[in_tile(x, y)] =
            picture[static_cast<std::size_t>(py) * width + static_cast<std::size_t>(px)];
        return true;
    });
    return tile;
}

std::optional<PixelDifference> compare_tiles(const RecordedFrame& frame, std::uint32_t region,
                                             std::span<const std::uint32_t> tile,
                                             std::span<const std::uint32_t> expected) {
    std::optional<PixelDifference> difference;
    each_pixel(frame, region, [&](int x, int y, int px, int py) {
        const std::uint32_t p = tile[in_tile(x, y)] & color_mask,
                            q = expected[in_tile(x, y)] & color_mask;
        if (p != q) {
            difference = PixelDifference{px, py, p, q};
        }
        return p == q;
    });
    return difference;
}

std::string color_text(std::uint32_t pixel) {
    return fmt::format("#{:02x}{:02x}{:02x}", pixel & 0xFF, pixel >> 8 & 0xFF, pixel >> 16 & 0xFF);
}

std::string color_difference(const PixelDifference& pixel, std::string_view found_in,
                             std::string_view expected_in) {
    constexpr std::array<const char*, 3> names = {"red", "green", "blue"};
    std::string text;
    for (unsigned k = 0; k < 3; ++k) {
        const std::uint32_t p = pixel.found >> (8 * k) & 0xFF, q = pixel.expected >> (8 * k) & 0xFF;
        std::string bits;
        for (unsigned bit = 0; bit < 8; ++bit) {
            bits +=
                ((p ^ q) >> bit & 1) != 0 ? fmt::format("{}{}", bits.empty() ? "" : ", ", bit) : "";
        }
        if (p != q) {
            text += fmt::format("{}{} is {} in {} and {} in {} ({} {})", text.empty() ? "" : ", ",
                                names[k], p, found_in, q, expected_in,
                                bits.size() > 1 ? "bits" : "bit", bits);
        }
    }
    return text;
}

std::string region_name(const RecordedFrame& frame, std::uint32_t region) {
    const RegionPlace place = frame.place(region);
    return fmt::format(
        "region {} (column {}, row {}{})", region, place.column, place.row,
        frame.draw().views()->size() > 1 ? fmt::format(", view {}", place.view) : "");
}

}  // namespace pxpl5::host::inspect
