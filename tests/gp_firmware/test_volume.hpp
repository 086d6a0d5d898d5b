// Small volumes made from functions, and what a machine of several GPs extracts from them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <memory>
#include <random>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "gp_firmware/surface/marching_cubes.hpp"
#include "gp_firmware/volume/slice_store.hpp"
#include "gp_firmware/volume/typed.hpp"

namespace pxpl5::test {

struct Volume {
    gp::VolumeShape shape;
    std::vector<std::byte> values;

    std::span<const std::byte> slice(int z) const {
        const std::size_t size_bytes = shape.slice_voxels() * pxpl5::size_bytes(shape.type);
        return std::span(values).subspan(static_cast<std::size_t>(z) * size_bytes, size_bytes);
    }
};

struct Size {
    int nx, ny, nz;
};

/// A volume whose voxel (x, y, z) is field(x, y, z), rounded to nearest for integer types.
template <class Field>
Volume make_volume(Size size, Scalar type, Field field) {
    Volume volume;
    volume.shape = {size.nx, size.ny, size.nz, type, glm::dmat4(1.0), 0, 0};
    double low = std::numeric_limits<double>::infinity(), high = -low;
    gp::with_scalar(type, [&]<class T>(T) {
        std::vector<T> values;
        for (int z = 0; z < size.nz; ++z)
            for (int y = 0; y < size.ny; ++y)
                for (int x = 0; x < size.nx; ++x) {
                    const double value = field(x, y, z);
                    if constexpr (std::is_integral_v<T>) {
                        using Limits = std::numeric_limits<T>;
                        values.push_back(static_cast<T>(
                            std::clamp<double>(std::round(value), Limits::min(), Limits::max())));
                    } else {
                        values.push_back(static_cast<T>(value));
                    }
                    if (std::isnan(value)) continue;
                    low = std::min(low, static_cast<double>(values.back()));
                    high = std::max(high, static_cast<double>(values.back()));
                }
        volume.values.resize(values.size() * sizeof(T));
        std::memcpy(volume.values.data(), values.data(), volume.values.size());
    });
    volume.shape.minimum = low;
    volume.shape.maximum = high;
    return volume;
}

inline constexpr std::size_t plenty_bytes = std::size_t{1} << 40;

/// One GP: its memory and its slices, all of them arrived.
struct Gp {
    Gp(const Volume& volume, gp::Share share) : store(volume.shape, share, memory) {
        for (const int z : gp::slices_needed(volume.shape, share))
            store.add_slice(z, volume.slice(z));
    }
    gp::LocalMemory memory{plenty_bytes};
    gp::SliceStore store;
};

/// The meshes of all slabs, in slab order, as `gp_count` GPs extract them.
inline std::vector<gp::SlabMesh> extract_all(const Volume& volume, double isovalue,
                                             CaseRule rule = CaseRule::watertight,
                                             int gp_count = 1) {
    std::vector<gp::SlabMesh> meshes(static_cast<std::size_t>(volume.shape.slab_count()));
    for (int i = 0; i < gp_count; ++i) {
        const Gp gp(volume, {i, gp_count});
        for (const int slab : gp.store.slabs())
            gp::extract_slab(gp.store, slab, isovalue, gp::case_table(rule),
                             meshes[static_cast<std::size_t>(slab)]);
    }
    return meshes;
}

/// The volume with one voxel more on every side, of value `outside`.
inline Volume padded(const Volume& volume, double outside) {
    const auto& shape = volume.shape;
    return make_volume(
        {shape.nx + 2, shape.ny + 2, shape.nz + 2}, shape.type, [&](int x, int y, int z) {
            const bool in =
                x >= 1 && y >= 1 && z >= 1 && x <= shape.nx && y <= shape.ny && z <= shape.nz;
            if (!in) return outside;
            double value = 0;
            gp::with_scalar(shape.type, [&]<class T>(T) {
                const std::ptrdiff_t row = (z - 1) * shape.ny + y - 1;
                value = gp::typed<T>(volume.values)[row * shape.nx + x - 1];
            });
            return value;
        });
}

}  // namespace pxpl5::test
