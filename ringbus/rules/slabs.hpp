// Distribution of slabs and slices to GPs: the host and the GPs compute it alike. Plain.
// Source: Yoo & Chen, section IV, "Dataset distribution".
#pragma once

#include <algorithm>
#include <vector>

namespace pxpl5 {

/// Each GP gets at least this many sets of slabs of a large volume, so that no GP alone holds a
/// dense part of the volume.
inline constexpr int sets_per_gp = 2;
/// Slabs of a set. 32 make the slices of all sets 9 % more than the volume.
inline constexpr int max_slabs_per_set = 32;
/// Slabs of a block, which one GP simplifies alone. Block b begins at slab block_slabs * b.
inline constexpr int block_slabs = 16;

/// A volume's slabs, shared by `gp_count` GPs. Slab s lies between slices s and s + 1.
struct SlabSets {
    int nz = 0;             ///< Slices.
    int slabs_per_set = 1;  ///< Adjacent slabs that belong to one GP.
    int gp_count = 1;

    int slab_count() const { return nz - 1; }

    /// The index of the GP that owns `slab`.
    int owner(int slab) const { return slab / slabs_per_set % gp_count; }

    bool owns(int gp, int slab) const {
        return slab >= 0 && slab < slab_count() && owner(slab) == gp;
    }

    /// True if every block of slabs belongs to one GP, so that surfaces can be simplified.
    bool have_whole_blocks() const {
        return gp_count == 1 || slabs_per_set >= slab_count() || slabs_per_set % block_slabs == 0;
    }

    /// True if slice z bounds a slab that the GP owns.
    bool bounds_own_slab(int gp, int z) const { return owns(gp, z) || owns(gp, z - 1); }

    /// True if the GP must receive slice z: z is in s - 1 .. s + 2 for a slab s that the GP owns.
    bool needs(int gp, int z) const {
        return bounds_own_slab(gp, z) || owns(gp, z + 1) || owns(gp, z - 2);
    }

    /// The GP whose trace records slice z: the owner of slab z; for the last slice, of slab z - 1.
    int recorder(int z) const { return owner(std::max(std::min(z, nz - 2), 0)); }

    /// Numbers 0 .. end - 1 that satisfy `predicate`, ascending.
    template <typename Predicate>
    static std::vector<int> numbers_below(int end, const Predicate& predicate) {
        std::vector<int> numbers;
        for (int i = 0; i < end; ++i) {
            if (predicate(i)) {
                numbers.push_back(i);
            }
        }
        return numbers;
    }

    /// Slices that the GP must receive, ascending.
    std::vector<int> slices_needed(int gp) const {
        return numbers_below(nz, [&](int z) { return needs(gp, z); });
    }
};

/// The size of the sets of a volume that is too large for sets of one slab. Sets have whole blocks
/// if the volume has enough slabs for them.
inline int slabs_per_large_set(int slab_count, int gp_count) {
    const int sets = gp_count * sets_per_gp;
    const int most = std::clamp((slab_count + sets - 1) / sets, 2, max_slabs_per_set);
    return most < block_slabs ? most : most / block_slabs * block_slabs;
}

}  // namespace pxpl5
