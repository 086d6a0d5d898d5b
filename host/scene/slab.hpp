// Slabs: the mean, the maximum or the minimum of neighboring slices, voxel by voxel.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "host/scene/slice.hpp"

namespace pxpl5::host {

enum class SlabKind : std::uint8_t { mean, max, min };
inline constexpr std::array<std::string_view, 3> slab_kinds = {"mean", "max", "min"};

struct SlabWish {
    double thickness_mm = 0;  ///< 0: a single slice.
    SlabKind kind = SlabKind::mean;
};

/// Slices of a slab, first to last.
struct SlabRange {
    int first = 0, last = 0;
    int count() const { return last - first + 1; }
};

/// Returns the slices whose middles are at most half of the thickness from the middle of slice
/// `index`, along the normal of the slices. The slices at both ends count as whole slices.
/// axis   0 x, 1 y, 2 z.
/// index  0 .. voxels along the axis - 1 (asserted).
SlabRange slab_range(const Volume& volume, int axis, int index, double thickness_mm);

/// Computes a slab from its slices. Projects along the voxel axis. If the gantry was tilted, this
/// axis is not perpendicular to the slices.
class SlabGather {
  public:
    explicit SlabGather(SlabKind kind) : kind_(kind) {}

    /// Adds a slice. All slices have the same frame and type (asserted).
    void add(const Slice& slice);

    /// Returns maximum and minimum in the type of the slices, the mean as float32 (the mean in
    /// float64, rounded once). Values that are no number do not count. If a pixel has no number in
    /// any slice, its value is no number. Call this once, after add().
    Slice finish();

  private:
    template <class T>
    void write_values();

    SlabKind kind_;
    Slice slab_;                  ///< Frame and type of the slices.
    std::vector<double> values_;  ///< Sum, maximum or minimum so far.
    std::vector<int> counts_;     ///< Numbers so far.
};

}  // namespace pxpl5::host
