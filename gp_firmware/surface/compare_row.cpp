#include "gp_firmware/surface/compare_row.hpp"

// Highway compiles the part below once per kind of vector machine.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "gp_firmware/surface/compare_row.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "isa/contract/vector_target.hpp"

HWY_BEFORE_NAMESPACE();
namespace pxpl5::gp::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

template <class D, class V>
auto at_least(D, V values, V limit) {
    // Highway has no Ge for these integers. Max(a, b) == a means a >= b.
    if constexpr (hwy::IsFloat<hn::TFromD<D>>()) {
        return hn::Ge(values, limit);
    } else {
        return hn::Eq(hn::Max(values, limit), values);
    }
}

/// Bits of 64 voxels.
template <class T>
std::uint64_t compare_64(const T* values, T threshold) {
    const hn::CappedTag<T, 64> d;
    const std::size_t lanes = hn::Lanes(d);
    const auto limit = hn::Set(d, threshold);
    std::uint64_t bits = 0;
    for (std::size_t x = 0; x < 64; x += lanes) {
        // StoreMaskBits writes one bit per lane, in whole bytes, whose spare bits are 0.
        std::uint64_t part = 0;
        const auto inside = at_least(d, hn::LoadU(d, values + x), limit);
        hn::StoreMaskBits(d, inside, reinterpret_cast<std::uint8_t*>(&part));
        bits |= part << x;
    }
    return bits;
}

template <class T>
void compare_row_in_vectors(const T* row, std::size_t count, T threshold, std::uint64_t* mask) {
    std::size_t x = 0;
    for (; x + 64 <= count; x += 64) {
        mask[x / 64] = compare_64(row + x, threshold);
    }
    if (x == count) {
        return;
    }
    if (count >= 64) {  // The row's last 64 voxels overlap the word before.
        mask[x / 64] = compare_64(row + count - 64, threshold) >> (64 - (count - x));
        return;
    }
    std::uint64_t bits = 0;
    for (; x < count; ++x) {
        bits |= std::uint64_t{row[x] >= threshold} << x;
    }
    mask[0] = bits;
}

void compare_uint8(const std::uint8_t* row, std::size_t count, std::uint8_t threshold,
                   std::uint64_t* mask) {
    compare_row_in_vectors(row, count, threshold, mask);
}
void compare_int16(const std::int16_t* row, std::size_t count, std::int16_t threshold,
                   std::uint64_t* mask) {
    compare_row_in_vectors(row, count, threshold, mask);
}
void compare_uint16(const std::uint16_t* row, std::size_t count, std::uint16_t threshold,
                    std::uint64_t* mask) {
    compare_row_in_vectors(row, count, threshold, mask);
}
void compare_float(const float* row, std::size_t count, float threshold, std::uint64_t* mask) {
    compare_row_in_vectors(row, count, threshold, mask);
}

}  // namespace pxpl5::gp::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace pxpl5::gp {

void compare_row(const std::uint8_t* row, std::size_t count, std::uint8_t threshold,
                 std::uint64_t* mask) {
    PXPL5_DISPATCH(compare_uint8)(row, count, threshold, mask);
}
void compare_row(const std::int16_t* row, std::size_t count, std::int16_t threshold,
                 std::uint64_t* mask) {
    PXPL5_DISPATCH(compare_int16)(row, count, threshold, mask);
}
void compare_row(const std::uint16_t* row, std::size_t count, std::uint16_t threshold,
                 std::uint64_t* mask) {
    PXPL5_DISPATCH(compare_uint16)(row, count, threshold, mask);
}
void compare_row(const float* row, std::size_t count, float threshold, std::uint64_t* mask) {
    PXPL5_DISPATCH(compare_float)(row, count, threshold, mask);
}

}  // namespace pxpl5::gp
#endif
