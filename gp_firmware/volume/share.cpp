#include "gp_firmware/volume/share.hpp"

#include <algorithm>

#include "gp_firmware/volume/gradient.hpp"
#include "gp_firmware/volume/run_length.hpp"
#include "ringbus/rules/slices_file.hpp"

namespace pxpl5::gp {

namespace {

bool fits(VolumeShape shape, int gp_count, std::size_t memory_bytes, std::size_t surface_bytes,
          double packing) {
    shape.slabs_per_set = slabs_per_set_with(shape, gp_count);
    for (int i = 0; i < gp_count; ++i) {
        const Share share{i, gp_count};
        const std::size_t slabs = slabs_owned(shape, share).size();
        const std::size_t surfaces =
            surface_bytes * slabs / static_cast<std::size_t>(shape.slab_count());
        const std::size_t peak =
            packing == 1 ? peak_bytes(shape, share) : packed_peak_bytes(shape, share, packing);
        if (peak + surfaces > memory_bytes) {
            return false;
        }
    }
    return true;
}

}  // namespace

SlabSets slab_sets(const VolumeShape& shape, int gp_count) {
    return {shape.nz, shape.slabs_per_set, gp_count};
}

int slabs_per_set_with(const VolumeShape& shape, int gp_count) {
    return shape.slabs_per_set == 1 ? 1 : slabs_per_large_set(shape.slab_count(), gp_count);
}

std::vector<int> slabs_owned(const VolumeShape& shape, Share share) {
    const SlabSets sets = slab_sets(shape, share.gp_count);
    return SlabSets::numbers_below(shape.slab_count(),
                                   [&](int s) { return sets.owns(share.gp_index, s); });
}

bool is_own(const VolumeShape& shape, Share share, int z) {
    return slab_sets(shape, share.gp_count).bounds_own_slab(share.gp_index, z);
}

std::vector<int> slices_needed(const VolumeShape& shape, Share share) {
    return slab_sets(shape, share.gp_count).slices_needed(share.gp_index);
}

std::vector<int> slices_kept(const VolumeShape& shape, Share share) {
    if (!shape.holds_gradients()) {
        return slices_needed(shape, share);
    }
    return SlabSets::numbers_below(shape.nz, [&](int z) { return is_own(shape, share, z); });
}

int discarded_after(const VolumeShape& shape, Share share, int z) {
    if (is_own(shape, share, z) || !shape.holds_gradients()) {
        return shape.nz;
    }
    const bool owns_next = slab_sets(shape, share.gp_count).owns(share.gp_index, z + 1);
    return owns_next ? std::min(z + 2, shape.nz - 1) : z;
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

std::size_t packed_peak_bytes(const VolumeShape& shape, Share share, double packing) {
    const std::size_t values = shape.slice_voxels() * size_bytes(shape.type);
    const auto packed = static_cast<std::size_t>(static_cast<double>(values) * packing);
    return max_unpacked_slices * values + slices_needed(shape, share).size() * packed;
}

int gp_count_that_would_do(const VolumeShape& shape, std::size_t memory_bytes,
                           std::size_t surface_bytes, double packing, int least) {
    for (int count = least; count <= max_nodes_per_role; ++count) {
        if (fits(shape, count, memory_bytes, surface_bytes, packing)) {
            return count;
        }
    }
    return 0;
}

std::string gp_count_advice(const VolumeShape& shape, std::size_t memory_bytes,
                            std::size_t surface_bytes, double packing) {
    const int count = gp_count_that_would_do(shape, memory_bytes, surface_bytes, packing);
    const std::uint64_t bytes = std::uint64_t{shape.slice_voxels()} *
                                static_cast<std::uint64_t>(shape.nz) * size_bytes(shape.type);
    const std::string remedy = bytes <= max_volume_bytes
                                   ? "; load with crop= or resample= to make the volume smaller"
                                   : "; a part of the volume, in a file of its own, needs less";
    const std::string each = " with " + std::to_string(memory_bytes) + " bytes each would ";
    if (count == 0) {
        return "even " + std::to_string(max_nodes_per_role) + " GPs" + each + "not do" + remedy;
    }
    return std::to_string(count) + (count == 1 ? " GP" : " GPs") + each + "do" + remedy;
}

}  // namespace pxpl5::gp
