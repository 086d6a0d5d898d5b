#include "gp_firmware/slices/slice_plane.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "gp_firmware/volume/typed.hpp"
#include "isa/contract/region_layout.hpp"

namespace pxpl5::gp {

namespace {

constexpr int unit = isa::region::normal_unit;

/// The slab that has all triangles of a plane across z.
int home_slab(const SlicePlane& plane, const VolumeShape& shape) {
    return std::min(plane.index, shape.slab_count() - 1);
}

/// Two sides of a plane's part in a slab, in voxels: along the volume's first axis that lies in the
/// plane, and along the second.
struct Extent {
    int across = 0, down = 0;
};

Extent extent_of(const SlicePlane& plane, const VolumeShape& shape) {
    switch (plane.axis) {
        case 0:
            return {shape.ny, 2};
        case 1:
            return {shape.nx, 2};
        default:
            return {shape.nx, shape.ny};
    }
}

int rows_per_piece(const Extent& extent) {
    constexpr int squares_per_piece = 25'000;
    return std::max(squares_per_piece / (extent.across - 1), 1);
}

/// The normals' z of all gray values: transform() returns the gray value again.
std::array<std::int16_t, unit + 1> make_packed_grays() {
    std::array<std::int16_t, unit + 1> packed{};
    for (int gray = 0; gray <= unit; ++gray) {
        packed[static_cast<std::size_t>(gray)] =
            static_cast<std::int16_t>(std::lround(static_cast<float>(gray) * normal_one / unit));
    }
    return packed;
}

/// Returns the gray value in 9 bits. The step that is added rounds the upper 8 bits.
std::size_t gray_of(float value, const SlicePlane& plane) {
    const double gray = (double{value} - plane.black) * unit / (plane.white - plane.black);
    if (!(gray > 0)) {  // NaN too.
        return 1;
    }
    return static_cast<std::size_t>(
        std::min(std::floor(std::min(gray, double{unit})) + 1, double{unit}));
}

}  // namespace

std::string plane_refusal(const SlicePlane& plane, const VolumeShape& shape) {
    const std::array sizes{shape.nx, shape.ny, shape.nz};
    const int count = sizes.at(static_cast<std::size_t>(plane.axis));
    return plane.index >= 0 && plane.index < count
               ? ""
               : fmt::format("slice {} across {} was requested, but the volume has slices 0 to {}",
                             plane.index, "xyz"[plane.axis], count - 1);
}

std::uint32_t plane_triangles(const SlicePlane& plane, const VolumeShape& shape, int slab) {
    if (plane.axis == 2 && slab != home_slab(plane, shape)) {
        return 0;
    }
    const Extent extent = extent_of(plane, shape);
    return 2 * static_cast<std::uint32_t>(extent.across - 1) *
           static_cast<std::uint32_t>(extent.down - 1);
}

int plane_pieces(const SlicePlane& plane, const VolumeShape& shape, int slab) {
    if (plane_triangles(plane, shape, slab) == 0) {
        return 0;
    }
    const Extent extent = extent_of(plane, shape);
    return (extent.down - 2) / rows_per_piece(extent) + 1;
}

/// The plane's values in slice z: a row of the slice, or all of it.
std::span<const float> SlicePlanes::row(const SliceStore& store, const SlicePlane& plane, int z) {
    const auto is_wanted = [&](const Values& each) {
        return each.axis == plane.axis && each.index == plane.index;
    };
    if (const auto held = std::ranges::find_if(values_, is_wanted); held != values_.end()) {
        std::rotate(held, held + 1, values_.end());
    } else {
        if (values_.size() == max_slice_planes) {
            values_.erase(values_.begin());
        }
        values_.push_back({plane.axis, plane.index, {}});
    }
    std::vector<float>& row = values_.back().rows[z];
    if (row.empty()) {
        const VolumeShape& shape = store.shape();
        const auto nx = static_cast<std::size_t>(shape.nx), ny = static_cast<std::size_t>(shape.ny);
        const auto at = static_cast<std::size_t>(plane.index);
        const std::vector<std::byte>& slice = store.slice(z).values;
        with_scalar(shape.type, [&]<class T>(T) {
            const T* values = typed<T>(slice);
            if (plane.axis == 0) {
                row.resize(ny);
                for (std::size_t y = 0; y < ny; ++y) {
                    row[y] = static_cast<float>(values[y * nx + at]);
                }
            } else if (plane.axis == 1) {
                row.assign(values + at * nx, values + (at + 1) * nx);
            } else {
                row.assign(values, values + nx * ny);
            }
        });
    }
    return row;
}

const SlabMesh& SlicePlanes::mesh(const SliceStore& store, const SlicePlane& plane, int slab,
                                  int piece, bool origins) {
    assert(store.complete() && std::ranges::count(store.slabs(), slab) == 1);
    const VolumeShape& shape = store.shape();
    assert(piece >= 0 && piece < plane_pieces(plane, shape, slab));
    const Extent extent = extent_of(plane, shape);
    const int first = piece * rows_per_piece(extent);
    const int last = std::min(first + rows_per_piece(extent), extent.down - 1);
    mesh_.slab = slab;
    mesh_.vertices.clear();
    mesh_.indices.clear();
    mesh_.origins.clear();
    for (int down = first; down <= last; ++down) {
        add_corners(store, plane, slab, down);
    }
    const auto across = static_cast<std::uint32_t>(extent.across);
    for (int down = first; down < last; ++down) {
        for (std::uint32_t i = 0; i + 1 < across; ++i) {
            const std::uint32_t corner = static_cast<std::uint32_t>(down - first) * across + i;
            const std::uint32_t below = corner + across;
            mesh_.indices.insert(mesh_.indices.end(),
                                 {corner, corner + 1, below + 1, corner, below + 1, below});
            if (origins) {
                add_origins(plane, static_cast<int>(i), down);
            }
        }
    }
    return mesh_;
}

/// Adds a row of corners: row `down` of the slice, or of the slab's lower or upper slice.
void SlicePlanes::add_corners(const SliceStore& store, const SlicePlane& plane, int slab,
                              int down) {
    static const std::array packed = make_packed_grays();
    const VolumeShape& shape = store.shape();
    const int z = plane.axis == 2 ? plane.index : slab + down;
    std::span<const float> values = row(store, plane, z);
    if (plane.axis == 2) {
        const auto nx = static_cast<std::size_t>(shape.nx);
        values = values.subspan(static_cast<std::size_t>(down) * nx, nx);
    }
    const auto at = static_cast<float>(plane.index), place = static_cast<float>(shape.place(z));
    float along = 0;
    for (const float value : values) {
        const glm::vec3 p = plane.axis == 0   ? glm::vec3(at, along, place)
                            : plane.axis == 1 ? glm::vec3(along, at, place)
                                              : glm::vec3(along, static_cast<float>(down), place);
        mesh_.vertices.push_back({p, {0, 0, packed[gray_of(value, plane)]}});
        ++along;
    }
}

void SlicePlanes::add_origins(const SlicePlane& plane, int across, int down) {
    Origin origin;
    origin.i = static_cast<std::uint16_t>(plane.axis == 0 ? plane.index : across);
    origin.j = static_cast<std::uint16_t>(plane.axis == 0   ? across
                                          : plane.axis == 1 ? plane.index
                                                            : down);
    mesh_.origins.push_back(origin);
    origin.triangle = 1;
    mesh_.origins.push_back(origin);
}

}  // namespace pxpl5::gp
