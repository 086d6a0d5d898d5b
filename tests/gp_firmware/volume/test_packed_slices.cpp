// Slices that do not fit into the memory as they are: kept compressed, with the same values.
#include <doctest/doctest.h>

#include <cmath>
#include <cstring>
#include <random>
#include <string>
#include <vector>

#include "gp_firmware/surface/marching_cubes.hpp"
#include "gp_firmware/volume/slice_packer.hpp"
#include "tests/gp_firmware/test_volume.hpp"

using namespace pxpl5;
using namespace pxpl5::gp;
using namespace pxpl5::test;

namespace {

pxpl5::test::Volume waves(Scalar type) {
    pxpl5::test::Volume volume = make_volume({48, 40, 33}, type, [](int x, int y, int z) {
        return std::round(100 + 60 * std::sin(x * 0.2) * std::cos(y * 0.15) +
                          30 * std::sin(z * 0.3));
    });
    volume.shape.slabs_per_set = 4;
    return volume;
}

bool same(const std::vector<std::byte>& a, std::span<const std::byte> b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), b.size()) == 0;
}

/// A store of all slices with `bytes` of memory.
struct Stored {
    Stored(const pxpl5::test::Volume& volume, Share share, std::size_t bytes)
        : memory(bytes), store(volume.shape, share, memory) {
        for (const int z : slices_needed(volume.shape, share)) {
            store.add_slice(z, volume.slice(z));
        }
    }
    LocalMemory memory;
    SliceStore store;
};

}  // namespace

TEST_SUITE("packed slices") {
    TEST_CASE("the packer restores every byte of every type, of noise too") {
        std::mt19937 random(3);
        for (const std::size_t size : {1U, 2U, 4U}) {
            SlicePacker packer(size);
            for (const int bits : {1, 5, 8}) {
                std::vector<std::byte> values(size * 1000);
                for (std::byte& byte : values) {
                    byte = static_cast<std::byte>(random() % (1U << static_cast<unsigned>(bits)));
                }
                const std::vector<std::byte> packed = packer.pack(values);
                CHECK((bits == 8 || packed.size() < values.size()));
                std::vector<std::byte> again(values.size());
                packer.unpack(packed, again);
                CHECK(again == values);
            }
        }
    }

    TEST_CASE("damaged bytes are no slice") {
        SlicePacker packer(2);
        const std::vector<std::byte> values(64, std::byte{7});
        std::vector<std::byte> packed = packer.pack(values), again(64), less(62);
        CHECK_THROWS_AS(packer.unpack(packed, less), std::logic_error);
        packed.pop_back();
        CHECK_THROWS_AS(packer.unpack(packed, again), std::logic_error);
    }

    TEST_CASE("slices and meshes are those of a store that does not compress, in any order") {
        for (const Scalar type : {Scalar::uint8, Scalar::int16, Scalar::uint16, Scalar::float32}) {
            const pxpl5::test::Volume volume = waves(type);
            for (const int count : {1, 2}) {
                const Share share{count - 1, count};
                const std::size_t raw = peak_bytes(volume.shape, share);
                Stored plain(volume, share, raw), packed(volume, share, raw * 3 / 4);
                CHECK(!plain.store.is_packed());
                CHECK(packed.store.is_packed());
                CHECK(packed.memory.used_bytes() < packed.memory.size_bytes());
                CHECK(packed.store.memory_bytes() == packed.memory.used_bytes());
                std::vector<int> order = packed.store.held();
                std::shuffle(order.begin(), order.end(), std::mt19937(5));
                for (const int z : order) {
                    CHECK(same(packed.store.slice(z).values, volume.slice(z)));
                }
                for (const int slab : packed.store.slabs()) {
                    SlabMesh a, b;
                    extract_slab(plain.store, slab, 110.5, case_table(CaseRule::watertight), a);
                    extract_slab(packed.store, slab, 110.5, case_table(CaseRule::watertight), b);
                    CHECK(a.keys == b.keys);
                    CHECK(a.indices == b.indices);
                    CHECK(a.counts.area_mm2 == b.counts.area_mm2);
                    REQUIRE(a.vertices.size() == b.vertices.size());
                    CHECK(std::memcmp(a.vertices.data(), b.vertices.data(),
                                      a.vertices.size() * sizeof(Vertex)) == 0);
                }
            }
        }
    }

    TEST_CASE("at most four slices are restored at a time") {
        const pxpl5::test::Volume volume = waves(Scalar::int16);
        const Share share{0, 1};
        Stored packed(volume, share, peak_bytes(volume.shape, share) * 3 / 4);
        const HeldSlice& first = packed.store.slice(3);
        for (const int z : {4, 5, 6, 3}) {
            packed.store.slice(z);
        }
        CHECK(same(first.values, volume.slice(3)));
        for (const int z : {7, 8, 9}) {
            packed.store.slice(z);
        }
        CHECK(same(first.values, volume.slice(3)));
        packed.store.slice(10);
        CHECK(first.values.empty());
    }

    TEST_CASE("noise does not fit, and the number of GPs that would do does") {
        std::mt19937 random(11);
        pxpl5::test::Volume volume = make_volume({48, 40, 60}, Scalar::int16, [&](int, int, int) {
            return static_cast<double>(random() % 60000) - 30000;
        });
        volume.shape.slabs_per_set = 8;
        const std::size_t bytes = peak_bytes(volume.shape, {0, 1}) * 2 / 3;
        std::string text;
        try {
            const Stored stored(volume, {0, 1}, bytes);
        } catch (const OutOfLocalMemory& error) {
            text = error.what();
        }
        CHECK(text.find(", compressed: needs ") != std::string::npos);
        const std::size_t at = text.find("; ") + 2;
        REQUIRE(at < text.size());
        const int count = std::stoi(text.substr(at));
        CHECK(text.find(" GPs with " + std::to_string(bytes) + " bytes each would do") !=
              std::string::npos);
        CHECK(count > 1);
        volume.shape.slabs_per_set = slabs_per_set_with(volume.shape, count);
        for (int i = 0; i < count; ++i) {
            CHECK_NOTHROW(Stored(volume, {i, count}, bytes));
        }
    }
}
