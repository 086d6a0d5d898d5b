#include "host/scene/slab.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <limits>

#include "host/scene/slice_places.hpp"
#include "host/volume/scalar_types.hpp"

namespace pxpl5::host {

namespace {

constexpr double rounding_mm = 1e-6;  // Slices at the end of a slab, despite rounded positions.

}  // namespace

SlabRange slab_range(const Volume& volume, int axis, int index, double thickness_mm) {
    const std::array counts = {volume.nx, volume.ny, volume.nz};
    const int count = counts.at(static_cast<std::size_t>(axis));
    assert(index >= 0 && index < count);
    const glm::dmat3 steps(volume.voxel_to_patient);
    const glm::dvec3 normal =
        glm::normalize(glm::cross(steps[(axis + 1) % 3], steps[(axis + 2) % 3]));
    const double step_mm = std::abs(glm::dot(normal, steps[axis]));
    const auto place_mm = [&](int i) {
        const bool is_uneven = axis == 2 && !volume.slice_places.empty();
        return step_mm * (is_uneven ? place_of_slice(i, volume.slice_places) : i);
    };
    const auto is_near = [&](int i) {
        return std::abs(place_mm(i) - place_mm(index)) <= thickness_mm / 2 + rounding_mm;
    };
    SlabRange range{index, index};
    while (range.first > 0 && is_near(range.first - 1)) {
        --range.first;
    }
    while (range.last + 1 < count && is_near(range.last + 1)) {
        ++range.last;
    }
    return range;
}

void SlabGather::add(const Slice& slice) {
    if (values_.empty()) {
        slab_.frame = slice.frame;
        slab_.type = slice.type;
        const std::size_t count = slice.values.size() / size_bytes(slice.type);
        constexpr double highest = std::numeric_limits<double>::infinity();
        values_.assign(count, kind_ == SlabKind::mean  ? 0
                              : kind_ == SlabKind::max ? -highest
                                                       : highest);
        counts_.assign(count, 0);
    }
    assert(slice.type == slab_.type &&
           slice.values.size() == values_.size() * size_bytes(slab_.type));
    const std::vector<double> numbers = numbers_of(slice);
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        if (std::isnan(numbers[i])) {
            continue;
        }
        double& so_far = values_[i];
        switch (kind_) {
            case SlabKind::mean:
                so_far += numbers[i];
                break;
            case SlabKind::max:
                so_far = std::max(so_far, numbers[i]);
                break;
            case SlabKind::min:
                so_far = std::min(so_far, numbers[i]);
        }
        ++counts_[i];
    }
}

template <class T>
void SlabGather::write_values() {
    slab_.values.resize(values_.size() * sizeof(T));
    for (std::size_t i = 0; i < values_.size(); ++i) {
        double value = values_[i];
        if (counts_[i] == 0) {  // Only float32 has values that are no number.
            value = std::numeric_limits<double>::quiet_NaN();
        } else if (kind_ == SlabKind::mean) {
            value /= counts_[i];
        }
        const auto written = static_cast<T>(value);
        std::memcpy(slab_.values.data() + i * sizeof written, &written, sizeof written);
    }
}

Slice SlabGather::finish() {
    assert(!values_.empty());
    if (kind_ == SlabKind::mean) {
        slab_.type = Scalar::float32;
    }
    with_scalar(slab_.type, [this]<typename T>(T*) { write_values<T>(); });
    return std::move(slab_);
}

}  // namespace pxpl5::host
