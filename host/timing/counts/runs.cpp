#include "host/timing/counts/runs.hpp"

#include <cassert>
#include <cstring>

namespace pxpl5::host::timing {

namespace {

template <typename Word>
std::uint64_t runs_of_words(const std::byte* row, SliceShape shape) {
    std::uint64_t runs = 0;
    for (std::uint32_t y = 0; y < shape.ny; ++y, row += shape.nx * sizeof(Word)) {
        ++runs;
        Word before{};
        std::memcpy(&before, row, sizeof before);
        for (std::size_t x = 1; x < shape.nx; ++x) {
            Word value{};
            std::memcpy(&value, row + x * sizeof value, sizeof value);
            runs += value == before ? 0 : 1;
            before = value;
        }
    }
    return runs;
}

}  // namespace

std::uint64_t runs_of(std::span<const std::byte> values, SliceShape shape) {
    assert(shape.nx >= 1);
    assert(shape.ny >= 1);
    assert(values.size() == std::size_t{shape.nx} * shape.ny * shape.voxel_bytes);
    switch (shape.voxel_bytes) {
        case sizeof(std::uint8_t):
            return runs_of_words<std::uint8_t>(values.data(), shape);
        case sizeof(std::uint16_t):
            return runs_of_words<std::uint16_t>(values.data(), shape);
        default:
            assert(shape.voxel_bytes == sizeof(std::uint32_t));
            return runs_of_words<std::uint32_t>(values.data(), shape);
    }
}

}  // namespace pxpl5::host::timing
