#include <doctest/doctest.h>

#include <memory>
#include <vector>

#include "renderer_firmware/hal/board.hpp"
#include "tests/renderer_firmware/targets.hpp"

using namespace pxpl5;
using namespace pxpl5::renderer::hal;
namespace isa = pxpl5::isa;

TEST_CASE("every pixel has a place of its own, and 4 x 4 pixels share 64 bytes of a column") {
    std::vector<bool> taken(region_pixels);
    for (std::size_t y = 0; y < 128; ++y) {
        for (std::size_t x = 0; x < 128; ++x) {
            const std::size_t index = pixel_index({x, y});
            REQUIRE(index < region_pixels);
            CHECK_FALSE(taken[index]);
            taken[index] = true;
            REQUIRE(place_of(index) == Place{x, y});
            REQUIRE(index / tile_pixels == pixel_index({x / 4 * 4, y / 4 * 4}) / tile_pixels);
            REQUIRE(index / block_pixels == y / 8 * 8 + x / 16);
        }
    }
    CHECK(alignof(Block) == 64);
    CHECK(sizeof(Block) == block_pixels * column_count * 4);
}

TEST_CASE("a field of any width at any bit is read across columns") {
    auto pixels = std::make_unique<PixelArray>();
    const std::size_t index = pixel_index({77, 99});
    std::vector<bool> bits(isa::memory_bits);
    std::uint32_t state = 12345;
    for (std::uint32_t k = 0; k < isa::memory_bits; ++k) {
        state = state * 1664525U + 1013904223U;
        bits[k] = (state >> 31) != 0;
        auto& word = pixels->blocks[index / block_pixels].columns[k / 32][index % block_pixels];
        word |= std::uint32_t{bits[k]} << k % 32;
    }
    for (std::uint32_t n = 1; n <= 64; ++n) {
        for (std::uint32_t a = 0; a + n <= isa::memory_bits; ++a) {
            std::uint64_t expected = 0;
            for (std::uint32_t k = 0; k < n; ++k) {
                expected |= std::uint64_t{bits[a + k]} << k;
            }
            REQUIRE(field(*pixels, index, a, n) == expected);
        }
    }
}

TEST_CASE("the port turns storage order into rows, its own or those it is given") {
    std::vector<std::uint32_t> stored(region_pixels);
    for (std::size_t i = 0; i < region_pixels; ++i) {
        const Place p = place_of(i);
        stored[i] = static_cast<std::uint32_t>(p.y * 128 + p.x);
    }
    const auto port = std::make_unique<Port>();
    std::vector<std::uint32_t> given(region_pixels);
    for (const bool is_own : {true, false, true}) {
        port->aim(is_own ? std::span<std::uint32_t>() : std::span(given));
        for (std::size_t b = 0; b < block_count; ++b) {
            port->put(b, std::span(stored).subspan(b * block_pixels).first<block_pixels>());
        }
        CHECK((port->rows().data() == given.data()) != is_own);
        for (std::uint32_t i = 0; i < region_pixels; ++i) {
            REQUIRE(port->rows()[i] == i);
        }
        given.assign(region_pixels, 0);
    }
    CHECK(given == std::vector<std::uint32_t>(region_pixels));
}

TEST_CASE("PIXELSTOFB writes where it was told to, and the sink sees it there") {
    pxpl5::test::on_every_target([](pxpl5::renderer::fast::Fast& fast) {
        std::vector<std::uint32_t> given(region_pixels);
        const std::uint32_t* seen = nullptr;
        fast.set_readout([&](auto words) { seen = words.data(); });
        const std::int32_t place[] = {1, 128, 0};
        fast.execute({isa::Op::set_enabs, {}}, {});
        fast.execute({isa::Op::tree_into_mem, {77, 0, 14}}, place);
        fast.read_out_into(given);
        fast.execute({isa::Op::pixels_to_fb, {77, 0, 13}}, {});
        CHECK(seen == given.data());
        for (std::uint32_t i = 0; i < region_pixels; ++i) {
            REQUIRE(given[i] == i % 8192);
        }
        const std::vector<std::uint32_t> before = given;
        fast.read_out_into({});
        fast.execute({isa::Op::pixels_to_fb, {77, 0, 3}}, {});
        CHECK(seen != given.data());
        CHECK(seen[15] == 7);
        CHECK(given == before);
    });
}

TEST_CASE("a backing-store block takes room when it is first opened, and starts as 0") {
    BackingStore store;
    CHECK(store.find(127) == nullptr);
    BackingStore::Words& words = store.open(127);
    CHECK(words.at[16383] == 0);
    words.at[16383] = 7;
    CHECK(store.find(127) == &words);
    CHECK(store.open(127).at[16383] == 7);
    CHECK(store.find(0) == nullptr);
}
