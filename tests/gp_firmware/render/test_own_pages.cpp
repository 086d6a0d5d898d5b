#include "gp_firmware/render/own_pages.hpp"

#include <doctest/doctest.h>
#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <limits>
#include <new>
#include <utility>

#include "gp_firmware/render/growing.hpp"

using pxpl5::gp::Growing;
using pxpl5::gp::OwnPages;

namespace {

/// Memory of this process that is in use, from /proc/self/statm.
std::size_t resident_bytes() {
    std::ifstream file("/proc/self/statm");
    std::size_t all = 0, resident = 0;
    file >> all >> resident;
    REQUIRE(resident > 0);
    return resident * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

}  // namespace

TEST_SUITE("gp/own pages") {
    TEST_CASE("a list keeps its values while it grows from the heap to pages of its own") {
        Growing<std::uint32_t> list;
        constexpr std::uint32_t count = 3'000'000;  // Two sizes beyond least_bytes, and more.
        static_assert(count * sizeof(std::uint32_t) > 8 * OwnPages::least_bytes);
        for (std::uint32_t value = 0; value < count; value += 1000) {
            std::uint32_t* const values = list.append(1000);
            for (std::uint32_t i = 0; i < 1000; ++i) {
                values[i] = value + i;
            }
        }
        REQUIRE(list.size() == count);
        std::uint32_t expected = 0;
        CHECK(std::ranges::all_of(list.values(), [&](auto value) { return value == expected++; }));
        const std::uint32_t* const before = list.data();
        list.clear();
        CHECK(list.append(count) == before);  // The capacity stays.
    }

    TEST_CASE("growing leaves no memory over, and unwritten pages take none") {
#if !defined(__SANITIZE_ADDRESS__)  // Whose allocator has no options.
        // As a GP: else the C library itself would return large blocks.
        REQUIRE(mallopt(M_MMAP_THRESHOLD, 1 << 30) == 1);
        REQUIRE(mallopt(M_TRIM_THRESHOLD, 1 << 30) == 1);
#endif
        constexpr std::size_t step = 1 << 20, written = 64 << 20;
        const std::size_t before = resident_bytes();
        OwnPages pages;
        std::size_t used = 0;
        for (std::size_t bytes = step; used < written; bytes *= 2) {
            pages.grow(used, bytes);
            const std::size_t end = std::min(bytes, written);
            std::fill(pages.data() + used, pages.data() + end, std::byte{1});
            used = end;
        }
        pages.grow(used, 4 * written);
        CHECK(pages.bytes() >= 4 * written);
        CHECK(resident_bytes() < before + written + written / 4);
        CHECK(std::all_of(pages.data(), pages.data() + written,
                          [](std::byte byte) { return byte == std::byte{1}; }));
        pages = OwnPages();
        CHECK(resident_bytes() < before + written / 4);
    }

    TEST_CASE("without memory a block stays as it was") {
        for (const std::size_t bytes : {std::size_t{100}, OwnPages::least_bytes}) {
            OwnPages pages;
            pages.grow(0, bytes);
            pages.data()[99] = std::byte{7};
            constexpr std::size_t too_many = std::numeric_limits<std::size_t>::max() / 4;
            CHECK_THROWS_AS(pages.grow(100, too_many), std::bad_alloc);
            CHECK(pages.bytes() >= bytes);
            CHECK(pages.data()[99] == std::byte{7});
        }
    }

    TEST_CASE("a block moves with its bytes") {
        OwnPages pages;
        pages.grow(0, 2 * OwnPages::least_bytes);
        pages.data()[5] = std::byte{9};
        OwnPages other = std::move(pages);
        CHECK(other.data()[5] == std::byte{9});
        OwnPages third;
        third.grow(0, 10);
        third = std::move(other);
        CHECK(third.data()[5] == std::byte{9});
        Growing<int> list;
        *list.append(1) = 3;
        Growing<int> taken = std::move(list);
        CHECK(taken.values().front() == 3);
        *list.append(1) = 4;  // NOLINT(bugprone-use-after-move): it is empty.
        CHECK(list.size() == 1);
        taken = std::move(list);
        CHECK(taken.values().front() == 4);
        CHECK(list.empty());  // NOLINT(bugprone-use-after-move): it is.
        CHECK_THROWS_AS(taken.append(std::numeric_limits<std::size_t>::max()), std::bad_alloc);
        CHECK(taken.values().front() == 4);
    }
}
