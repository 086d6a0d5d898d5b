// Frames whose views come from one frame buffer or from two.
#include <doctest/doctest.h>

#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "host/machine/port.hpp"
#include "host/session/transfer/frame_parts.hpp"
#include "tests/ringbus/wire_bytes.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
namespace schema = bus::schema;

namespace {

constexpr int width = 130, height = 2;  // Two regions.

/// The message of a frame buffer whose pixels, cycles and Renderers count up from `first`.
bus::Message done(std::uint32_t frame, int views, std::uint32_t first, double moved_mm = 0) {
    schema::FrameDoneT message;
    message.frame = frame;
    message.width = width;
    message.height = height;
    message.views = static_cast<std::uint16_t>(views);
    message.instructions = 100 + first;
    message.moved_mm = moved_mm;
    for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(width * height * views); ++i) {
        message.pixels.push_back(1000 * first + i);
        message.depths.push_back(2000 * first + i);
    }
    for (std::uint32_t region = 0; region < static_cast<std::uint32_t>(2 * views); ++region) {
        message.region_cycles.push_back(10 * first + region);
        message.region_renderers.push_back(static_cast<std::uint16_t>(first + region));
    }
    return test::WireBytes(bus::pack(message)).read();
}

using Words = std::vector<std::uint32_t>;

Words words_of(std::span<const std::uint32_t> words) {
    return {words.begin(), words.end()};
}

}  // namespace

TEST_SUITE("host/session/frame_parts") {
    TEST_CASE("a pair from two frame buffers is the stack that one frame buffer sends") {
        FrameParts parts({width, height}, 2, 2);
        CHECK(!parts.is_complete());
        parts.take(1, done(7, 1, 3, 0.5));  // The right eye's came first.
        CHECK(!parts.is_complete());
        parts.take(0, done(7, 1, 1, 0.25));
        REQUIRE(parts.is_complete());
        const WholeFrame whole = parts.whole();
        Words pixels, depths;
        for (const std::uint32_t first : {1U, 3U}) {
            for (std::uint32_t i = 0; i < width * height; ++i) {
                pixels.push_back(1000 * first + i);
                depths.push_back(2000 * first + i);
            }
        }
        CHECK(words_of(whole.pixels) == pixels);
        CHECK(words_of(whole.depths) == depths);
        CHECK(whole.frame == 7);
        CHECK(whole.views == 2);
        CHECK(whole.view == Size{width, height});
        CHECK(whole.region_cycles == std::vector<std::uint64_t>{10, 11, 30, 31});
        CHECK(whole.region_renderers == std::vector<std::uint16_t>{1, 2, 3, 4});
        CHECK(whole.instructions == 101 + 103);
        CHECK(whole.moved_mm == 0.5);
    }

    TEST_CASE("one frame buffer sends all views, and one view needs no second frame buffer") {
        for (const std::size_t views : {1U, 2U}) {
            FrameParts parts({width, height}, views, views == 1 ? 2 : 1);
            const bus::Message only = done(2, static_cast<int>(views), 5);
            parts.take(0, only);
            REQUIRE(parts.is_complete());
            const WholeFrame whole = parts.whole();
            CHECK(whole.pixels.data() == only.as<schema::FrameDone>()->pixels()->data());
            CHECK(whole.pixels.size() == views * width * height);
            CHECK(whole.region_cycles.size() == 2 * views);
        }
    }

    TEST_CASE("the words of a frame stay when its messages are gone") {
        for (const std::size_t frame_buffers : {1U, 2U}) {
            std::optional<FrameParts> parts(std::in_place, Size{width, height}, 2, frame_buffers);
            for (std::size_t index = 0; index < frame_buffers; ++index) {
                parts->take(index, done(7, static_cast<int>(2 / frame_buffers), 4));
            }
            const WholeFrame whole = parts->whole();
            const SharedWords copied = whole.depths;
            parts.reset();
            CHECK(whole.pixels[0] == 4000);
            CHECK(copied[1] == 8001);
            CHECK(copied.data() == whole.depths.data());
        }
    }

    TEST_CASE("a message with other views than the frame buffer has is refused by its name") {
        const auto refusal = [](FrameParts parts, std::size_t index, const bus::Message& message) {
            try {
                parts.take(index, message);
            } catch (const MachineError& error) {
                CHECK(error.node == "framebuffer-" + std::to_string(index));
                return std::string(error.what());
            }
            return std::string("no error");
        };
        const FrameParts pair({width, height}, 2, 2);
        CHECK(refusal(pair, 1, done(7, 2, 1)) ==
              "framebuffer-1 sent frame 7 with 2 views of 130 x 2 pixels, must have 1 of 130 x 2. "
              "Build all nodes again");
        CHECK(refusal(FrameParts({width, height}, 1, 2), 1, done(7, 1, 1))
                  .find("1 views of 130 x 2 pixels, must have 0") != std::string::npos);
        CHECK(refusal(FrameParts({width, 3}, 1, 1), 0, done(7, 1, 1))
                  .find("must have 1 of 130 x 3") != std::string::npos);
        CHECK(refusal(pair, 0, done(7, 1, 1)) == "no error");
    }
}
