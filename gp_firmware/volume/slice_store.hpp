// One GP's share of the volume: the slices of its slabs, with gradients.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "gp_firmware/hal/local_memory.hpp"
#include "gp_firmware/volume/gradient.hpp"
#include "gp_firmware/volume/run_length.hpp"
#include "gp_firmware/volume/share.hpp"
#include "gp_firmware/volume/slice.hpp"

namespace pxpl5::gp {

struct HeldSlice {
    std::vector<std::byte> values;    ///< nx * ny of the volume's type, x fastest.
    std::vector<Gradient> gradients;  ///< nx * ny; empty if they are not held, and until both
                                      ///< neighbours in z were there.
    RowIndex rows;                    ///< Only for slices of slabs that are owned.
};

struct StoreCounts {
    std::uint32_t slices = 0;        ///< That came, with those that are gone.
    std::uint32_t rows_in_runs = 0;  ///< Of slices that are held: rows whose runs are kept.
    std::uint64_t runs = 0;          ///< Of these rows.
};

/// Holds what a GP needs of a volume, and no more: a slice that no slab of the GP touches goes
/// as soon as no gradient needs it; one that several slabs touch is held once. Where gradients are
/// not held, the neighbours that they are estimated from stay.
///
/// Source  Yoo & Chen, section IV: four slices per set, "two of the four data slices may be
///         discarded" after gradient estimation.
class SliceStore {
  public:
    /// memory  The GP's budget; outlives the store, which gives back all when it ends.
    /// Throws  OutOfLocalMemory if the share cannot fit, before any slice arrives;
    ///         std::invalid_argument if shape or share is out of range.
    SliceStore(const VolumeShape& shape, Share share, LocalMemory& memory);
    ~SliceStore();
    SliceStore(const SliceStore&) = delete;
    SliceStore& operator=(const SliceStore&) = delete;

    /// Takes slice z. Slices come in the order of slices_needed().
    /// values  nx * ny voxels of shape.type, x fastest; copied.
    /// Throws  std::invalid_argument for another slice than the next one, or another size;
    ///         OutOfLocalMemory.
    void add_slice(int z, std::span<const std::byte> values);

    /// Whether all slices have come: only then may slabs be extracted.
    bool complete() const { return next_ == needed_.size(); }

    const VolumeShape& shape() const { return shape_; }
    const std::vector<int>& slabs() const { return slabs_; }  ///< Owned, ascending.
    std::vector<int> held() const;                            ///< Slices held now, ascending.
    const HeldSlice& slice(int z) const;                      ///< Asserts that z is held.
    /// Slice z with those that its gradients come from. All are held: z is of an owned slab, and
    /// it is still coming or gradients are not held.
    SliceNeighbours neighbours(int z) const;
    std::size_t memory_bytes() const { return charged_bytes_; }
    StoreCounts counts() const;

  private:
    void charge(std::size_t bytes, int z);
    void add_gradients(int z);
    void discard_done(int z);

    VolumeShape shape_;
    Share share_;
    LocalMemory& memory_;
    std::vector<int> slabs_, needed_;
    std::size_t next_ = 0;  ///< Index into needed_ of the next slice to come.
    std::map<int, HeldSlice> slices_;
    std::size_t charged_bytes_ = 0;
};

}  // namespace pxpl5::gp
