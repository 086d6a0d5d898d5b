// Trilinear resampling.
#include <cmath>

#include "host/io/values/processing.hpp"
#include "host/io/values/scalar_types.hpp"

namespace pxpl5::host::io {

namespace {

/// A new voxel between two old ones: their indices, and the second's share.
struct Between {
    std::size_t lower = 0, upper = 0;
    double share = 0;
};

/// `places` ascends; positions outside are those of the border.
Between between(const std::vector<double>& places, double position) {
    const auto above = std::upper_bound(places.begin(), places.end(), position);
    if (above == places.begin()) {
        return {0, 0, 0};
    }
    const auto lower = static_cast<std::size_t>(above - places.begin()) - 1;
    if (lower + 1 == places.size()) {
        return {lower, lower, 0};
    }
    const double share = (position - places[lower]) / (places[lower + 1] - places[lower]);
    return {lower, lower + 1, share};
}

std::vector<Between> along(const std::vector<double>& places, NewAxis axis) {
    std::vector<Between> all;
    for (int i = 0; i < axis.size; ++i) {
        all.push_back(between(places, i * axis.step));
    }
    return all;
}

/// The places of `size` even voxels, or those of uneven slices.
std::vector<double> places_of(int size, const std::vector<double>& uneven) {
    if (!uneven.empty()) {
        return uneven;
    }
    std::vector<double> places;
    for (int i = 0; i < size; ++i) {
        places.push_back(i);
    }
    return places;
}

/// A share of 0 does not look at the other value, which may be NaN.
double mix(double a, double b, double share) {
    return share == 0 ? a : a * (1 - share) + b * share;
}

/// New slabs that overlap one of the old gaps.
std::vector<int> new_gaps(const Volume& volume, const std::vector<double>& places, NewAxis axis) {
    constexpr double touching = 1e-9;
    std::vector<int> gaps;
    for (int slab = 0; slab + 1 < axis.size; ++slab) {
        const double begin = slab * axis.step, end = (slab + 1) * axis.step;
        for (const int gap : volume.gap_slabs) {
            const auto i = static_cast<std::size_t>(gap);
            if (begin < places[i + 1] - touching && end > places[i] + touching) {
                gaps.push_back(slab);
                break;
            }
        }
    }
    return gaps;
}

template <typename T>
std::vector<std::byte> resampled(const Volume& volume,
                                 const std::array<std::vector<Between>, 3>& at) {
    const std::span<const T> old = typed<T>(std::span<const std::byte>(volume.values));
    const auto nx = static_cast<std::size_t>(volume.nx), ny = static_cast<std::size_t>(volume.ny);
    std::vector<std::byte> bytes(at[0].size() * at[1].size() * at[2].size() * sizeof(T));
    T* out = typed<T>(std::span<std::byte>(bytes)).data();
    for (const Between& z : at[2]) {
        for (const Between& y : at[1]) {
            const T* rows[2][2] = {{old.data() + (z.lower * ny + y.lower) * nx,
                                    old.data() + (z.lower * ny + y.upper) * nx},
                                   {old.data() + (z.upper * ny + y.lower) * nx,
                                    old.data() + (z.upper * ny + y.upper) * nx}};
            for (const Between& x : at[0]) {
                const auto in_row = [&](const T* row) {
                    return mix(static_cast<double>(row[x.lower]), static_cast<double>(row[x.upper]),
                               x.share);
                };
                const double lower = mix(in_row(rows[0][0]), in_row(rows[0][1]), y.share);
                const double upper = mix(in_row(rows[1][0]), in_row(rows[1][1]), y.share);
                *out++ = nearest<T>(mix(lower, upper, z.share));
            }
        }
    }
    return bytes;
}

}  // namespace

void resample(const std::array<NewAxis, 3>& axes, Volume& volume) {
    const std::vector<double> z_places = places_of(volume.nz, volume.slice_places);
    const std::array<std::vector<Between>, 3> at = {along(places_of(volume.nx, {}), axes[0]),
                                                    along(places_of(volume.ny, {}), axes[1]),
                                                    along(z_places, axes[2])};
    with_scalar(volume.type, [&]<typename T>(T*) { volume.values = resampled<T>(volume, at); });
    volume.gap_slabs = new_gaps(volume, z_places, axes[2]);
    volume.slice_places.clear();
    for (int axis = 0; axis < 3; ++axis) {
        volume.voxel_to_patient[axis] *= axes[static_cast<std::size_t>(axis)].step;
    }
    volume.nx = axes[0].size;
    volume.ny = axes[1].size;
    volume.nz = axes[2].size;
}

}  // namespace pxpl5::host::io
