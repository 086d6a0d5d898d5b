#include "gp_firmware/volume/run_length.hpp"

#include <algorithm>
#include <cassert>
#include <limits>
#include <type_traits>

#include "gp_firmware/volume/typed.hpp"

namespace pxpl5::gp {

namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

Range range_of(std::span<const float> row) {
    Range range{infinity, -infinity};
    for (const float value : row) {
        const bool nan = value != value;
        range.minimum = std::min(range.minimum, nan ? -infinity : value);
        range.maximum = std::max(range.maximum, nan ? -infinity : value);
    }
    return range;
}

template <class T>
Range range_of(std::span<const T> row) {
    T low = row[0], high = row[0];
    for (const T value : row) {
        low = std::min(low, value);
        high = std::max(high, value);
    }
    return {static_cast<float>(low), static_cast<float>(high)};
}

/// Appends the runs of `row`. Appends nothing if the row has more than `limit` runs.
template <class T>
void append_runs(std::span<const T> row, std::size_t limit, std::vector<Run>& runs) {
    const std::size_t before = runs.size();
    for (std::size_t x = 0; x < row.size(); ++x) {
        if (x + 1 < row.size() && row[x] == row[x + 1]) {
            continue;
        }
        if (runs.size() == before + limit) {
            return runs.resize(before);
        }
        runs.push_back({static_cast<float>(row[x]), static_cast<std::uint32_t>(x + 1)});
    }
}

std::size_t run_limit(const VolumeShape& shape) {
    return static_cast<std::size_t>(shape.nx / min_run_length);
}

/// Sets bits first .. end - 1.
void set_bits(std::span<std::uint64_t> mask, std::size_t first, std::size_t end) {
    for (std::size_t word = first / 64; word * 64 < end; ++word) {
        const std::size_t low = std::max(first, word * 64) - word * 64;
        const std::size_t high = std::min(end, word * 64 + 64) - word * 64;
        mask[word] |= (~std::uint64_t{0} >> (64 - (high - low))) << low;
    }
}

}  // namespace

std::size_t RowIndex::size_bytes() const {
    return ranges.size() * sizeof(Range) + run_first.size() * sizeof(std::uint32_t) +
           runs.size() * sizeof(Run);
}

std::size_t max_index_bytes(const VolumeShape& shape) {
    const auto ny = static_cast<std::size_t>(shape.ny);
    return ny * (sizeof(Range) + sizeof(std::uint32_t) + run_limit(shape) * sizeof(Run)) +
           sizeof(std::uint32_t);
}

RowIndex index_rows(const VolumeShape& shape, std::span<const std::byte> values) {
    assert(values.size() == shape.slice_voxels() * size_bytes(shape.type));
    RowIndex index{{infinity, -infinity}, {}, {0}, {}};
    const auto nx = static_cast<std::size_t>(shape.nx), ny = static_cast<std::size_t>(shape.ny);
    index.ranges.reserve(ny);
    index.run_first.reserve(ny + 1);
    with_scalar(shape.type, [&]<class T>(T) {
        for (std::size_t y = 0; y < ny; ++y) {
            const std::span<const T> row(typed<T>(values) + y * nx, nx);
            index.ranges.push_back(range_of(row));
            index.slice.minimum = std::min(index.slice.minimum, index.ranges.back().minimum);
            index.slice.maximum = std::max(index.slice.maximum, index.ranges.back().maximum);
            append_runs(row, run_limit(shape), index.runs);
            index.run_first.push_back(static_cast<std::uint32_t>(index.runs.size()));
        }
    });
    index.runs.shrink_to_fit();
    return index;
}

void mask_from_runs(std::span<const Run> runs, double isovalue, std::span<std::uint64_t> mask) {
    std::fill(mask.begin(), mask.end(), std::uint64_t{0});
    std::size_t first = 0;
    for (const Run& run : runs) {
        if (static_cast<double>(run.value) >= isovalue) {
            set_bits(mask, first, run.end);
        }
        first = run.end;
    }
}

}  // namespace pxpl5::gp
