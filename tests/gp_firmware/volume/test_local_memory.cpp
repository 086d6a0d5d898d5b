#include <doctest/doctest.h>

#include "gp_firmware/hal/local_memory.hpp"
#include "tests/gp_firmware/test_volume.hpp"

using namespace pxpl5;
using namespace pxpl5::gp;
using pxpl5::test::Gp;
using pxpl5::test::make_volume;

namespace {

/// The shape of the paper's CT, without its voxels.
VolumeShape paper_ct() {
    return {128, 128, 56, Scalar::int16, glm::dmat4(1.0), -1000, 3000};
}

}  // namespace

TEST_SUITE("gp/local_memory") {
    TEST_CASE("what does not fit is refused with both numbers, and takes nothing") {
        LocalMemory memory(100);
        memory.charge(60, "slice 1");
        try {
            memory.charge(41, "slice 2", "3 GPs would do");
            FAIL("41 bytes fitted into 40");
        } catch (const OutOfLocalMemory& error) {
            CHECK(error.needed_bytes == 41);
            CHECK(error.available_bytes == 40);
            CHECK(std::string(error.what()) ==
                  "slice 2: needs 41 bytes of local memory, 40 are free; 3 GPs would do");
        }
        CHECK(memory.used_bytes() == 60);
        memory.charge(40, "slice 2");
        memory.release(100);
        CHECK(memory.used_bytes() == 0);
    }

    TEST_CASE("the number of GPs that would do is the smallest with which every share fits") {
        const std::size_t memory_bytes = 2 << 20;
        const int count = gp_count_that_would_do(paper_ct(), memory_bytes);
        REQUIRE(count > 1);
        std::size_t greatest = 0, greatest_with_one_less = 0;
        for (int i = 0; i < count; ++i)
            greatest = std::max(greatest, peak_bytes(paper_ct(), {i, count}));
        for (int i = 0; i < count - 1; ++i)
            greatest_with_one_less =
                std::max(greatest_with_one_less, peak_bytes(paper_ct(), {i, count - 1}));
        CHECK(greatest <= memory_bytes);
        CHECK(greatest_with_one_less > memory_bytes);
        CHECK(gp_count_that_would_do(paper_ct(), memory_bytes, 40 << 20) > count);
        CHECK(gp_count_that_would_do(paper_ct(), 1000) == 0);
        CHECK(gp_count_advice(paper_ct(), 1000) ==
              "even 64 GPs with 1000 bytes each would not do; load with crop= or resample= to make "
              "the volume smaller");
        VolumeShape larger = paper_ct();
        larger.nx = larger.ny = 4096;
        larger.nz = 600;
        CHECK(gp_count_advice(larger, 1000) ==
              "even 64 GPs with 1000 bytes each would not do; a part of the volume, in a "
              "file of its own, needs less");
    }

    TEST_CASE("the paper's CT fits into 36 GPs of 8 MiB") {
        for (int i = 0; i < 36; ++i) CHECK(peak_bytes(paper_ct(), {i, 36}) < 8 << 20);
    }

    TEST_CASE("a share that cannot fit is refused before any slice, saying how many GPs would do") {
        LocalMemory memory(2 << 20);
        const int count = gp_count_that_would_do(paper_ct(), 2 << 20);
        const std::string advice = "; " + std::to_string(count) + " GPs with 2097152 bytes";
        try {
            const SliceStore store(paper_ct(), {0, 1}, memory);
            FAIL("the volume fitted");
        } catch (const OutOfLocalMemory& error) {
            CHECK(error.needed_bytes == peak_bytes(paper_ct(), {0, 1}));
            CHECK(error.available_bytes == 2 << 20);
            CHECK_MESSAGE(std::string(error.what()).find(advice) != std::string::npos,
                          error.what());
        }
    }

    TEST_CASE("a store stays within its peak while slices arrive, and gives all back") {
        std::mt19937 random(7);
        auto volume = make_volume({24, 9, 23}, Scalar::int16, [&](int x, int, int) {
            return x < 12 ? 5.0 : static_cast<double>(random() % 100);
        });
        for (const int count : {1, 2, 3, 4, 5, 22, 36})
            for (int n = 0; n < 2 * count; ++n) {
                const Share share{n / 2, count};
                volume.shape.slabs_per_set = n % 2 == 0 ? 1 : 3;
                LocalMemory memory(peak_bytes(volume.shape, share));
                std::size_t most = 0;
                {
                    SliceStore store(volume.shape, share, memory);
                    for (const int z : slices_needed(volume.shape, share)) {
                        store.add_slice(z, volume.slice(z));
                        most = std::max(most, memory.used_bytes());
                        CHECK(store.memory_bytes() == memory.used_bytes());
                    }
                }
                CHECK(most <= memory.size_bytes());
                CHECK(memory.used_bytes() == 0);
            }
    }
}
