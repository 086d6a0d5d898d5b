#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "host/timing/counts/runs.hpp"

namespace pxpl5::host::timing {

namespace {

template <typename T>
std::uint64_t runs(const std::vector<T>& values, std::uint32_t nx) {
    return runs_of(std::as_bytes(std::span(values)),
                   {nx, static_cast<std::uint32_t>(values.size() / nx),
                    static_cast<std::uint32_t>(sizeof(T))});
}

/// nx * ny voxels, neighbors along x different.
template <typename T>
std::vector<T> checkerboard(std::uint32_t nx, std::uint32_t ny) {
    std::vector<T> values;
    for (std::uint32_t at = 0; at < nx * ny; ++at) {
        values.push_back(static_cast<T>((at % nx + at / nx) % 2));
    }
    return values;
}

}  // namespace

TEST_CASE_TEMPLATE("a constant slice has a run a row, a checkerboard one a voxel", T, std::uint8_t,
                   std::int16_t, std::uint16_t, float) {
    CHECK(runs(std::vector<T>(7 * 5, T{3}), 7) == 5);
    CHECK(runs(checkerboard<T>(7, 5), 7) == 7 * 5);
}

TEST_CASE("a run ends with its row, though the next row goes on with the same value") {
    CHECK(runs(std::vector<std::uint8_t>{1, 1, 2, 2, 2, 2}, 3) == 3);
    CHECK(runs(std::vector<std::uint8_t>{1, 2, 1, 2}, 1) == 4);
}

TEST_CASE("all bytes of a value count, and of numbers with a point the bits") {
    CHECK(runs(std::vector<std::uint16_t>{0x0100, 0x0200, 0x0200, 0x0201}, 4) == 3);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    CHECK(runs(std::vector<float>{nan, nan, 0.F, -0.F}, 4) == 3);
}

}  // namespace pxpl5::host::timing
