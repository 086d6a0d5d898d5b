#include "host/scene/pick.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "host/base/error.hpp"
#include "host/scene/slice_places.hpp"
#include "host/volume/scalar_types.hpp"
#include "isa/contract/depth.hpp"

namespace pxpl5::host {

namespace {

constexpr std::uint32_t surface_bits = isa::region::surface.width;
constexpr std::uint32_t surface_mask = (1U << surface_bits) - 1;

/// Patient millimeters of a place in the view: pixels from the top left, z as OpenGL's -1..1.
glm::dvec3 unproject(const PickView& view, glm::dvec2 p_px, double z_ndc) {
    const glm::dmat4 to_patient = glm::inverse(view.camera.projection * view.camera.patient_to_eye);
    const glm::dvec4 p = to_patient * glm::dvec4(2 * p_px.x / view.width - 1,
                                                 1 - 2 * p_px.y / view.height, z_ndc, 1);
    return glm::dvec3(p) / p.w;
}

/// p_voxel, held at the volume's faces.
glm::dvec3 held_at_faces(const Pick& pick, const Volume& volume) {
    const glm::dvec3 last = glm::dvec3(volume.nx, volume.ny, volume.nz) - 1.0;
    return glm::clamp(pick.p_voxel, glm::dvec3(0), last);
}

/// Interpolates in the cell whose lowest voxel is `first`. value(up) is the value of the corner
/// that is `up` voxels, 0 or 1 along each axis, above the lowest one.
template <class Value>
double interpolated(const glm::dvec3& p_voxel, const glm::ivec3& first, const Value& value) {
    const glm::dvec3 f = glm::clamp(p_voxel - glm::dvec3(first), 0.0, 1.0);
    double sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::ivec3 up(corner & 1, corner >> 1 & 1, corner >> 2);
        double weight = 1;
        for (int axis = 0; axis < 3; ++axis) {
            weight *= up[axis] != 0 ? f[axis] : 1 - f[axis];
        }
        sum += weight * value(up);
    }
    return sum;
}

void look_at_voxels(const Volume& volume, Pick& found) {
    const glm::dvec3 held = held_at_faces(found, volume);
    found.is_in_volume = held == found.p_voxel;
    const glm::dvec3 nearest = glm::floor(held + 0.5);
    found.x = static_cast<int>(nearest.x);
    found.y = static_cast<int>(nearest.y);
    found.z = static_cast<int>(nearest.z);
    if (!volume.values.empty()) {
        found.value = voxel_value(volume, found.x, found.y, found.z);
        const glm::ivec3 first = cell_around(found, volume);
        found.value_between = interpolated(held, first, [&](const glm::ivec3& up) {
            return voxel_value(volume, first.x + up.x, first.y + up.y, first.z + up.z);
        });
    }
}

}  // namespace

glm::ivec3 cell_around(const Pick& pick, const Volume& volume) {
    const glm::dvec3 last = glm::dvec3(volume.nx, volume.ny, volume.nz) - 2.0;
    return glm::ivec3(glm::clamp(glm::floor(held_at_faces(pick, volume)), glm::dvec3(0), last));
}

void set_values(Pick& pick, const Volume& volume, const Volume& cell) {
    const glm::ivec3 first = cell_around(pick, volume);
    pick.value = voxel_value(cell, pick.x - first.x, pick.y - first.y, pick.z - first.z);
    pick.value_between =
        interpolated(held_at_faces(pick, volume), first,
                     [&](const glm::ivec3& up) { return voxel_value(cell, up.x, up.y, up.z); });
}

double voxel_value(const Volume& volume, int x, int y, int z) {
    assert(x >= 0 && x < volume.nx && y >= 0 && y < volume.ny && z >= 0 && z < volume.nz);
    const auto index = [](int i) { return static_cast<std::size_t>(i); };
    const std::size_t at = (index(z) * index(volume.ny) + index(y)) * index(volume.nx) + index(x);
    return with_scalar(volume.type, [&]<typename T>(T*) {
        T value{};
        assert((at + 1) * sizeof value <= volume.values.size());
        std::memcpy(&value, volume.values.data() + at * sizeof value, sizeof value);
        return static_cast<double>(value);
    });
}

std::optional<Pick> pick(const PickView& view, int x, int y, const Volume& volume) {
    if (x < 0 || x >= view.width || y < 0 || y >= view.height) {
        throw RequestError(ExitCode::usage,
                           fmt::format("pixel ({}, {}) is outside of the picture, which has {} x "
                                       "{} pixels, counted from 0",
                                       x, y, view.width, view.height));
    }
    const std::size_t at = static_cast<std::size_t>(y) * static_cast<std::size_t>(view.width) +
                           static_cast<std::size_t>(x);
    assert(at < view.depths.size());
    const std::uint32_t word = view.depths[at], depth = word >> surface_bits;
    if ((word & surface_mask) == 0) {
        return std::nullopt;
    }
    const glm::dvec2 center(x + 0.5, y + 0.5);
    Pick found;
    found.surface = static_cast<int>(word & surface_mask) - 1;
    found.depth = depth;
    found.p_mm = unproject(view, center, isa::ndc_of_depth(depth));
    found.doubt_mm =
        0.5 * glm::distance(found.p_mm, unproject(view, center, isa::ndc_of_depth(depth + 1)));
    found.p_grid = glm::dvec3(glm::inverse(volume.voxel_to_patient) * glm::dvec4(found.p_mm, 1));
    found.p_voxel = found.p_grid;
    found.p_voxel.z = slice_of_place(found.p_grid.z, volume.slice_places);
    look_at_voxels(volume, found);
    return found;
}

}  // namespace pxpl5::host
