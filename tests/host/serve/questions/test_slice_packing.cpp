// Slices for a slow link, taken apart again as the page does it.
#include <doctest/doctest.h>
#include <zlib.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <random>

#include "host/serve/director/slice_packing.hpp"

using namespace pxpl5::host::serve;

namespace {

/// The bytes before they were packed.
std::vector<std::byte> unpacked(const std::vector<std::byte>& packed, std::size_t bytes,
                                std::size_t count, std::size_t value_bytes) {
    std::vector<std::byte> plain(bytes);
    uLongf size = static_cast<uLongf>(bytes);
    REQUIRE(uncompress(reinterpret_cast<Bytef*>(plain.data()), &size,
                       reinterpret_cast<const Bytef*>(packed.data()),
                       static_cast<uLong>(packed.size())) == Z_OK);
    REQUIRE(size == bytes);
    const std::vector<std::byte> planes = plain;
    std::uint32_t value = 0;
    for (std::size_t k = 0; k < count; ++k) {
        for (std::size_t plane = 0; plane < value_bytes; ++plane) {
            value += std::to_integer<std::uint32_t>(planes[plane * count + k]) << 8 * plane;
        }
        std::memcpy(plain.data() + k * value_bytes, &value, value_bytes);
    }
    return plain;
}

}  // namespace

TEST_SUITE("slice_packing") {
    TEST_CASE("values of every size and what follows them come back bit for bit") {
        std::mt19937 random(1993);
        for (const std::size_t value_bytes : {1U, 2U, 4U}) {
            for (const std::size_t count : {1U, 2U, 63U, 4096U}) {
                std::vector<std::byte> bytes(count * value_bytes + 24);
                for (std::byte& each : bytes) {
                    each = static_cast<std::byte>(random());
                }
                CHECK(unpacked(pack_slice(bytes, count, value_bytes), bytes.size(), count,
                               value_bytes) == bytes);
            }
        }
    }

    TEST_CASE("smooth values of two bytes take less than half") {
        constexpr std::size_t side = 256;
        std::vector<std::byte> bytes(side * side * 2);
        for (std::size_t k = 0; k < side * side; ++k) {
            const double across = static_cast<double>(k % side),
                         down = static_cast<double>(k / side);
            const auto value = static_cast<std::int16_t>(1000 * std::sin(across / 40) + down);
            std::memcpy(bytes.data() + 2 * k, &value, sizeof value);
        }
        CHECK(2 * pack_slice(bytes, side * side, 2).size() < bytes.size());
    }
}
