#include <doctest/doctest.h>

#include <set>

#include "gp_firmware/volume/slice_store.hpp"
#include "tests/gp_firmware/test_volume.hpp"

using namespace pxpl5;
using namespace pxpl5::gp;
using pxpl5::test::Gp;
using pxpl5::test::make_volume;
using pxpl5::test::plenty_bytes;

namespace {

pxpl5::test::Volume noise(pxpl5::test::Size size, Scalar type) {
    std::mt19937 random(11);
    return make_volume(size, type, [&](int, int, int) { return double(random() % 200); });
}

bool same(const HeldSlice& a, const HeldSlice& b) {
    return a.values == b.values && a.gradients == b.gradients &&
           a.rows.run_first == b.rows.run_first;
}

}  // namespace

TEST_SUITE("gp/slice_store") {
    TEST_CASE("slabs go round-robin, and every slab has its four slices, fewer at the ends") {
        const VolumeShape shape{4, 4, 10, Scalar::uint8, glm::dmat4(1.0), 0, 1};
        CHECK(slabs_owned(shape, {1, 4}) == std::vector<int>{1, 5});
        CHECK(slices_needed(shape, {1, 4}) == std::vector<int>{0, 1, 2, 3, 4, 5, 6, 7});
        CHECK(slices_kept(shape, {1, 4}) == std::vector<int>{1, 2, 5, 6});
        CHECK(slices_needed(shape, {0, 9}) == std::vector<int>{0, 1, 2});
        CHECK(slices_needed(shape, {8, 9}) == std::vector<int>{7, 8, 9});
        CHECK(slices_needed(shape, {4, 9}) == std::vector<int>{3, 4, 5, 6});
        CHECK(slices_needed(shape, {9, 10}).empty());
        const VolumeShape two{4, 4, 2, Scalar::uint8, glm::dmat4(1.0), 0, 1};
        CHECK(slices_needed(two, {0, 3}) == std::vector<int>{0, 1});
    }

    TEST_CASE("sets of several slabs go round-robin, and share their neighbors' slices") {
        const VolumeShape shape{4, 4, 12, Scalar::uint8, glm::dmat4(1.0), 0, 1, 3};
        CHECK(slabs_owned(shape, {0, 2}) == std::vector<int>{0, 1, 2, 6, 7, 8});
        CHECK(slabs_owned(shape, {1, 2}) == std::vector<int>{3, 4, 5, 9, 10});
        CHECK(slices_needed(shape, {1, 3}) == std::vector<int>{2, 3, 4, 5, 6, 7});
        CHECK(slices_needed(shape, {1, 2}) == std::vector<int>{2, 3, 4, 5, 6, 7, 8, 9, 10, 11});
        CHECK(slices_kept(shape, {1, 3}) == slices_needed(shape, {1, 3}));
        CHECK(slices_needed(shape, {4, 5}).empty());
    }

    TEST_CASE("each slab belongs to exactly one GP") {
        VolumeShape shape{4, 4, 57, Scalar::uint8, glm::dmat4(1.0), 0, 1};
        for (const int count : {1, 2, 5, 36, 64})
            for (const int slabs_per_set : {1, 2, 7, 100}) {
                shape.slabs_per_set = slabs_per_set;
                std::multiset<int> slabs;
                for (int i = 0; i < count; ++i)
                    for (const int slab : slabs_owned(shape, {i, count})) slabs.insert(slab);
                CHECK(slabs.size() == 56);
                CHECK(std::set<int>(slabs.begin(), slabs.end()).size() == 56);
            }
    }

    TEST_CASE("larger sets hold no gradients, but the slices that they come from") {
        auto volume = noise({9, 5, 17}, Scalar::int16);
        volume.shape.slabs_per_set = 4;
        const Gp gp(volume, {1, 3});
        CHECK(gp.store.complete());
        CHECK(gp.store.slabs() == std::vector<int>{4, 5, 6, 7});
        CHECK(gp.store.held() == std::vector<int>{3, 4, 5, 6, 7, 8, 9});
        std::size_t bytes = 0;
        for (const int z : gp.store.held()) {
            CHECK(gp.store.slice(z).gradients.empty());
            bytes += gp.store.slice(z).values.size();
            bytes += z >= 4 && z <= 8 ? gp.store.slice(z).rows.size_bytes() : 0;
        }
        CHECK(gp.memory.used_bytes() == bytes);
        CHECK(bytes <= peak_bytes(volume.shape, {1, 3}));
    }

    TEST_CASE("what is held in the end is the slices of the slabs, each once, with gradients") {
        for (const int nz : {2, 3, 4, 5, 17}) {
            const auto volume = noise({9, 5, nz}, Scalar::int16);
            const Gp all(volume, {0, 1});
            for (const int count : {1, 2, 3, 4, 5, 36})
                for (int i = 0; i < count; ++i) {
                    const Gp gp(volume, {i, count});
                    CHECK(gp.store.complete());
                    CHECK(gp.store.held() == slices_kept(volume.shape, {i, count}));
                    std::size_t bytes = 0;
                    for (const int z : gp.store.held()) {
                        CHECK(same(gp.store.slice(z), all.store.slice(z)));
                        bytes += volume.shape.slice_voxels() * (2 + sizeof(Gradient)) +
                                 gp.store.slice(z).rows.size_bytes();
                    }
                    CHECK(gp.memory.used_bytes() == bytes);
                }
        }
    }

    TEST_CASE("two of a set's four slices go as soon as the gradients are there") {
        const auto volume = noise({4, 4, 9}, Scalar::uint8);
        LocalMemory memory(plenty_bytes);
        SliceStore store(volume.shape, {2, 8}, memory);
        const std::vector<std::vector<int>> held = {{1}, {1, 2}, {2, 3}, {2, 3}};
        for (const int z : {1, 2, 3, 4}) {
            store.add_slice(z, volume.slice(z));
            CHECK(store.held() == held[static_cast<std::size_t>(z - 1)]);
        }
        CHECK(store.complete());
    }

    TEST_CASE("a slice out of turn, of a wrong size or one too many is refused by number") {
        const auto volume = noise({4, 4, 3}, Scalar::uint8);
        LocalMemory memory(plenty_bytes);
        SliceStore store(volume.shape, {0, 1}, memory);
        CHECK_THROWS_WITH_AS(store.add_slice(1, volume.slice(1)),
                             "slice 1 arrived, but slice 0 is next", std::invalid_argument);
        CHECK_THROWS_WITH_AS(store.add_slice(0, volume.slice(0).first(15)),
                             "slice 0 needs 16 bytes, has 15", std::invalid_argument);
        for (const int z : {0, 1, 2}) {
            CHECK_FALSE(store.complete());
            store.add_slice(z, volume.slice(z));
        }
        CHECK_THROWS_WITH_AS(store.add_slice(2, volume.slice(2)),
                             "slice 2 arrived, but the GP has all of its slices",
                             std::invalid_argument);
        CHECK(store.complete());
    }

    TEST_CASE("impossible shapes and shares are refused") {
        LocalMemory memory(plenty_bytes);
        VolumeShape shape{4, 4, 1, Scalar::uint8, glm::dmat4(1.0), 0, 1};
        CHECK_THROWS_WITH_AS(SliceStore(shape, {0, 1}, memory),
                             "a volume needs 2 voxels along each axis, has 4x4x1",
                             std::invalid_argument);
        shape.nz = 4;
        CHECK_THROWS_AS(SliceStore(shape, {0, 0}, memory), std::invalid_argument);
        CHECK_THROWS_AS(SliceStore(shape, {0, 65}, memory), std::invalid_argument);
        CHECK_THROWS_AS(SliceStore(shape, {3, 3}, memory), std::invalid_argument);
        CHECK_THROWS_AS(SliceStore(shape, {-1, 3}, memory), std::invalid_argument);
    }
}
