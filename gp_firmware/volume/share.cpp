#include "gp_firmware/volume/share.hpp"

#include <algorithm>

#include "gp_firmware/volume/gradient.hpp"
#include "gp_firmware/volume/run_length.hpp"

namespace pxpl5::gp {

namespace {

bool owns(const VolumeShape& shape, Share share, int slab) {
    return slab >= 0 && slab < shape.slab_count() &&
           owner_of(shape, share.gp_count, slab) == share.gp_index;
}

template <class Predicate>
std::vector<int> numbers_below(int end, Predicate predicate) {
    std::vector<int> numbers;
    for (int i = 0; i < end; ++i) {
        if (predicate(i)) {
            numbers.push_back(i);
        }
    }
    return numbers;
}

constexpr int sets_per_gp = 2, max_slabs_per_set = 32;

bool fits(VolumeShape shape, int gp_count, std::size_t memory_bytes, std::size_t surface_bytes) {
    shape.slabs_per_set = slabs_per_set_with(shape, gp_count);
    for (int i = 0; i < gp_count; ++i) {
        const Share share{i, gp_count};
        const std::size_t slabs = slabs_owned(shape, share).size();
        const std::size_t surfaces =
            surface_bytes * slabs / static_cast<std::size_t>(shape.slab_count());
        if (peak_bytes(shape, share) + surfaces > memory_bytes) {
            return false;
        }
    }
    return true;
}

}  // namespace

int owner_of(const VolumeShape& shape, int gp_count, int slab) {
    return slab / shape.slabs_per_set % gp_count;
}

int slabs_per_set_with(const VolumeShape& shape, int gp_count) {
    const int sets = gp_count * sets_per_gp;
    return shape.slabs_per_set == 1
               ? 1
               : std::clamp((shape.slab_count() + sets - 1) / sets, 2, max_slabs_per_set);
}

int slab_that_records(const VolumeShape& shape, int z) {
    return std::max(std::min(z, shape.nz - 2), 0);
}

std::vector<int> slabs_owned(const VolumeShape& shape, Share share) {
    return numbers_below(shape.slab_count(), [&](int s) { return owns(shape, share, s); });
}

bool is_own(const VolumeShape& shape, Share share, int z) {
    return owns(shape, share, z) || owns(shape, share, z - 1);
}

std::vector<int> slices_needed(const VolumeShape& shape, Share share) {
    return numbers_below(shape.nz, [&](int z) {
        return is_own(shape, share, z) || owns(shape, share, z + 1) || owns(shape, share, z - 2);
    });
}

std::vector<int> slices_kept(const VolumeShape& shape, Share share) {
    if (!shape.holds_gradients()) {
        return slices_needed(shape, share);
    }
    return numbers_below(shape.nz, [&](int z) { return is_own(shape, share, z); });
}

int discarded_after(const VolumeShape& shape, Share share, int z) {
    if (is_own(shape, share, z) || !shape.holds_gradients()) {
        return shape.nz;
    }
    return owns(shape, share, z + 1) ? std::min(z + 2, shape.nz - 1) : z;
}

std::size_t peak_bytes(const VolumeShape& shape, Share share) {
    const std::size_t values = shape.slice_voxels() * size_bytes(shape.type);
    const std::size_t extra =
        (shape.holds_gradients() ? shape.slice_voxels() * sizeof(Gradient) : 0) +
        max_index_bytes(shape);
    std::size_t peak = 0, used = 0;
    const std::vector<int> needed = slices_needed(shape, share);
    for (const int z : needed) {
        used += values + (is_own(shape, share, z) ? extra : 0);
        peak = std::max(peak, used);
        for (const int old : needed) {
            if (old <= z && discarded_after(shape, share, old) == z) {
                used -= values;
            }
        }
    }
    return peak;
}

int gp_count_that_would_do(const VolumeShape& shape, std::size_t memory_bytes,
                           std::size_t surface_bytes) {
    for (int count = 1; count <= max_gp_count; ++count) {
        if (fits(shape, count, memory_bytes, surface_bytes)) {
            return count;
        }
    }
    return 0;
}

std::string gp_count_advice(const VolumeShape& shape, std::size_t memory_bytes,
                            std::size_t surface_bytes) {
    const int count = gp_count_that_would_do(shape, memory_bytes, surface_bytes);
    const std::string each = " with " + std::to_string(memory_bytes) + " bytes each would ";
    if (count == 0) {
        return "even " + std::to_string(max_gp_count) + " GPs" + each + "not do";
    }
    return std::to_string(count) + (count == 1 ? " GP" : " GPs") + each + "do";
}

}  // namespace pxpl5::gp
