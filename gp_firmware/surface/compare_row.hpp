// Vector comparison of a row of voxels with a threshold.
#pragma once

#include <cstddef>
#include <cstdint>

namespace pxpl5::gp {

/// Sets bit x of mask[x / 64] where row[x] >= threshold, for x < count; the last word's other
/// bits are 0. The result does not depend on the vector instructions that the machine has.
void compare_row(const std::uint8_t* row, std::size_t count, std::uint8_t threshold,
                 std::uint64_t* mask);
void compare_row(const std::int16_t* row, std::size_t count, std::int16_t threshold,
                 std::uint64_t* mask);
void compare_row(const std::uint16_t* row, std::size_t count, std::uint16_t threshold,
                 std::uint64_t* mask);
void compare_row(const float* row, std::size_t count, float threshold, std::uint64_t* mask);

}  // namespace pxpl5::gp
