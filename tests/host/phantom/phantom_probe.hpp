// Phantoms as tests look at them: voxels by patient position, and surfaces by the GPs' own code.
#pragma once

#include <cstring>
#include <string_view>

#include "gp_firmware/volume/typed.hpp"
#include "host/phantom/phantom.hpp"
#include "tests/gp_firmware/test_volume.hpp"

namespace pxpl5::test {

/// A made phantom, with its voxels as numbers.
struct Probe {
    host::Volume volume;
    std::vector<double> voxels;

    explicit Probe(std::string_view name) : volume(host::make_phantom(name)) {
        gp::with_scalar(static_cast<Scalar>(volume.type), [&]<class T>(T) {
            std::vector<T> typed(volume.values.size() / sizeof(T));
            std::memcpy(typed.data(), volume.values.data(), volume.values.size());
            voxels.assign(typed.begin(), typed.end());
        });
    }

    double at(int x, int y, int z) const {
        return voxels.at((static_cast<std::size_t>(z) * static_cast<std::size_t>(volume.ny) +
                          static_cast<std::size_t>(y)) *
                             static_cast<std::size_t>(volume.nx) +
                         static_cast<std::size_t>(x));
    }
    glm::dvec3 place_mm(int x, int y, int z) const {
        return glm::dvec3(volume.voxel_to_patient * glm::dvec4(x, y, z, 1));
    }
    /// The voxel nearest to a place in the patient.
    double near_mm(double x, double y, double z) const {
        const glm::dvec4 p = glm::inverse(volume.voxel_to_patient) * glm::dvec4(x, y, z, 1);
        return at(static_cast<int>(std::lround(p.x)), static_cast<int>(std::lround(p.y)),
                  static_cast<int>(std::lround(p.z)));
    }
    /// Calls `visit(value, place in mm)` for every voxel.
    template <class Visit>
    void each(const Visit& visit) const {
        for (int z = 0; z < volume.nz; ++z)
            for (int y = 0; y < volume.ny; ++y)
                for (int x = 0; x < volume.nx; ++x) visit(at(x, y, z), place_mm(x, y, z));
    }
};

/// The volume as GPs receive it.
inline Volume for_gps(const host::Volume& v) {
    return {
        {v.nx, v.ny, v.nz, static_cast<Scalar>(v.type), v.voxel_to_patient, v.minimum, v.maximum},
        v.values};
}

inline host::PhantomInfo info_of(std::string_view name) {
    for (const host::PhantomInfo& info : host::phantoms())
        if (info.name == name) return info;
    throw std::out_of_range(std::string(name));
}

}  // namespace pxpl5::test
