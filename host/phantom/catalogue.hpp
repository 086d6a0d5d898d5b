// The phantoms, one maker each, and what they share.
#pragma once

#include <bit>
#include <cassert>
#include <cstring>

#include "host/phantom/field.hpp"
#include "host/phantom/phantom.hpp"

namespace pxpl5::host::phantom {

static_assert(std::endian::native == std::endian::little, "Volume::values are little endian");

PhantomInfo pelvis_info();
PhantomInfo fetus_info();
PhantomInfo head_info();
PhantomInfo sphere_info();
PhantomInfo torus_info();
PhantomInfo letters_info();
PhantomInfo heart_info();
PhantomInfo waving_fetus_info();

Volume make_pelvis(const PhantomInfo& info);
Volume make_fetus(const PhantomInfo& info);
Volume make_head(const PhantomInfo& info);
Volume make_sphere(const PhantomInfo& info);
Volume make_torus(const PhantomInfo& info);
Volume make_letters(const PhantomInfo& info);
/// frame  From 1.
Volume make_heart(const PhantomInfo& info, int frame);
Volume make_waving_fetus(const PhantomInfo& info, int frame);

/// The grid that an info describes, centered on `center_mm`.
inline Grid grid_of(const PhantomInfo& info, glm::vec3 center_mm = glm::vec3(0)) {
    const glm::vec3 spacing(static_cast<float>(info.spacing_mm[0]),
                            static_cast<float>(info.spacing_mm[1]),
                            static_cast<float>(info.spacing_mm[2]));
    return centered_grid(info.dims[0], info.dims[1], info.dims[2], spacing, center_mm);
}

/// Rounds half up, into the range of T.
template <class T>
T rounded(float value) {
    constexpr float low = static_cast<float>(std::numeric_limits<T>::min());
    constexpr float high = static_cast<float>(std::numeric_limits<T>::max());
    const float shifted = std::min(std::max(value, low), high) - low + 0.5F;
    return static_cast<T>(static_cast<std::int32_t>(shifted) + static_cast<std::int32_t>(low));
}

/// 0 at or below `low`, 1 at or above `high`, smooth between.
inline float ramp(float value, float low, float high) {
    const float t = std::min(std::max((value - low) / (high - low), 0.0F), 1.0F);
    return t * t * (3 - 2 * t);
}

/// Packs voxels of one type with their place.
template <class T>
Volume volume_of(const PhantomInfo& info, const Grid& grid, const std::vector<T>& voxels) {
    assert(sizeof(T) == size_bytes(info.type));
    assert(voxels.size() == grid.voxel_count());
    Volume volume;
    volume.name = info.name;
    volume.nx = grid.nx;
    volume.ny = grid.ny;
    volume.nz = grid.nz;
    volume.type = info.type;
    for (int i = 0; i < 3; ++i) {
        volume.voxel_to_patient[i][i] = static_cast<double>(grid.spacing_mm[i]);
        volume.voxel_to_patient[3][i] = static_cast<double>(grid.first_mm[i]);
    }
    const auto [low, high] = std::minmax_element(voxels.begin(), voxels.end());
    volume.minimum = static_cast<double>(*low);
    volume.maximum = static_cast<double>(*high);
    volume.findings = {{FindingKind::note, "computed, not scanned: " + info.description}};
    volume.values.resize(voxels.size() * sizeof(T));
    std::memcpy(volume.values.data(), voxels.data(), volume.values.size());
    return volume;
}

/// Says which volume of the phantom's time series it is.
inline void take_frame(const PhantomInfo& info, int frame, Volume& volume) {
    volume.frame = frame;
    volume.frames = info.frames;
    volume.frame_ms = info.frame_ms;
    volume.findings.push_back({FindingKind::note, "volume " + std::to_string(frame) + " of " +
                                                      std::to_string(info.frames) +
                                                      " of a time series"});
}

}  // namespace pxpl5::host::phantom
