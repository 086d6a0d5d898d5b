// A sphere and a torus: shapes whose area, volume and genus are known.
#include <limits>

#include "host/phantom/catalogue.hpp"

namespace pxpl5::host::phantom {

namespace {

constexpr double sphere_radius_mm = 30;
constexpr double torus_ring_radius_mm = 32, torus_tube_radius_mm = 12;
constexpr double steps_per_mm = 100;  ///< One unit of density is 0.01 mm.
constexpr int torus_zero = 30000;     ///< Density just outside the torus.

// Off the lattice, so that no voxel center lies on the shape's axes.
constexpr glm::dvec3 center_mm(0.3, -0.7, 0.45);

/// Depth in units: at least 1 exactly when the point is inside or on the surface, so that an
/// isovalue of one half stands for the surface itself, without bias.
int depth_units(double depth_mm) {
    return static_cast<int>(std::floor(depth_mm * steps_per_mm)) + 1;
}

template <class T, class Depth>
Volume depth_volume(const PhantomInfo& info, const Depth& depth_mm, int zero) {
    const Grid grid = grid_of(info);
    std::vector<T> voxels;
    voxels.reserve(grid.voxel_count());
    for (int z = 0; z < grid.nz; ++z) {
        for (int y = 0; y < grid.ny; ++y) {
            for (int x = 0; x < grid.nx; ++x) {
                const glm::dvec3 p(static_cast<double>(grid.x_mm(x)),
                                   static_cast<double>(grid.y_mm(y)),
                                   static_cast<double>(grid.z_mm(z)));
                const int units = zero + depth_units(depth_mm(p - center_mm));
                assert(units >= std::numeric_limits<T>::min());
                assert(units <= std::numeric_limits<T>::max());
                voxels.push_back(static_cast<T>(units));
            }
        }
    }
    return volume_of(info, grid, voxels);
}

}  // namespace

PhantomInfo sphere_info() {
    return {"phantom:sphere",
            "a sphere; density is depth below its surface in 0.01 mm",
            {64, 56, 48},
            Scalar::int16,
            {1.25, 1.5, 1.75},
            {{"surface", 0.5, {120, 170, 230}, 0}},
            {{"radius", sphere_radius_mm}}};
}

Volume make_sphere(const PhantomInfo& info) {
    return depth_volume<std::int16_t>(
        info,
        [](glm::dvec3 p) {
            return sphere_radius_mm - std::sqrt(p.x * p.x + p.y * p.y + p.z * p.z);
        },
        0);
}

PhantomInfo torus_info() {
    return {"phantom:torus",
            "a torus about the patient's long axis; density is 30000 + depth in 0.01 mm",
            {80, 64, 32},
            Scalar::uint16,
            {1.25, 1.5, 1.0},
            {{"surface", torus_zero + 0.5, {235, 170, 80}, 0}},
            {{"ring radius", torus_ring_radius_mm}, {"tube radius", torus_tube_radius_mm}}};
}

Volume make_torus(const PhantomInfo& info) {
    return depth_volume<std::uint16_t>(
        info,
        [](glm::dvec3 p) {
            const double off_ring = std::sqrt(p.x * p.x + p.y * p.y) - torus_ring_radius_mm;
            return torus_tube_radius_mm - std::sqrt(off_ring * off_ring + p.z * p.z);
        },
        torus_zero);
}

}  // namespace pxpl5::host::phantom
