// The slices of one GP's slabs, with gradients.
#pragma once

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "gp_firmware/hal/local_memory.hpp"
#include "gp_firmware/volume/gradient.hpp"
#include "gp_firmware/volume/run_length.hpp"
#include "gp_firmware/volume/share.hpp"
#include "gp_firmware/volume/slice.hpp"
#include "gp_firmware/volume/slice_packer.hpp"

namespace pxpl5::gp {

struct HeldSlice {
    std::vector<std::byte> values;    ///< nx * ny of the volume's type, x fastest.
    std::vector<Gradient> gradients;  ///< nx * ny; empty if gradients are not stored, and until
                                      ///< both neighbors in z have arrived.
    RowIndex rows;                    ///< Empty unless an owned slab touches the slice.
    std::vector<std::byte> packed;    ///< The values, compressed; then `values` is empty unless the
                                      ///< slice is among the last that were used.
};

struct StoreCounts {
    std::uint32_t slices = 0;        ///< Slices received, including discarded ones.
    std::uint32_t rows_in_runs = 0;  ///< Rows of stored slices that keep their runs.
    std::uint64_t runs = 0;          ///< Runs of these rows.
};

/// Stores the slices that a GP needs. It discards a slice that no slab of the GP touches as soon as
/// no gradient needs it, and stores a slice once even if several slabs touch it. If gradients are
/// not stored, it keeps the neighbor slices that they are estimated from. If these slices do not
/// fit into the memory as they are, it keeps them compressed.
///
/// Source  Yoo & Chen, section IV: four slices per set, "two of the four data slices may be
///         discarded" after gradient estimation.
class SliceStore {
  public:
    /// memory  The GP's budget. It outlives the store; the store's destructor returns all bytes.
    /// Throws  OutOfLocalMemory if the slices cannot fit, before any slice arrives;
    ///         std::invalid_argument if shape or share is out of range.
    SliceStore(const VolumeShape& shape, Share share, LocalMemory& memory);
    ~SliceStore();
    SliceStore(const SliceStore&) = delete;
    SliceStore& operator=(const SliceStore&) = delete;

    /// Adds slice z. Slices arrive in the order of slices_needed().
    /// values  nx * ny voxels of shape.type, x fastest; copied.
    /// Throws  std::invalid_argument if it is not the next slice, or has another size;
    ///         OutOfLocalMemory.
    void add_slice(int z, std::span<const std::byte> values);

    /// Returns whether all slices have arrived. Only then may slabs be extracted.
    bool complete() const { return next_ == needed_.size(); }

    /// Returns the number of the slice that add_slice() takes next. Asserts that some are missing.
    int next_slice() const {
        assert(!complete());
        return needed_[next_];
    }
    std::size_t received_count() const { return next_; }
    /// Returns how many slices the GP needs.
    std::size_t needed_count() const { return needed_.size(); }

    const VolumeShape& shape() const { return shape_; }
    const std::vector<int>& slabs() const { return slabs_; }  ///< Owned, ascending.
    std::vector<int> held() const;                            ///< Slices stored now, ascending.
    /// Returns slice z with its values. Asserts that z is stored. The values stay until
    /// max_unpacked_slices others have been used.
    const HeldSlice& slice(int z) const;
    /// Whether the slices are kept compressed.
    bool is_packed() const { return packer_ != nullptr; }
    /// Returns the share of their bytes that compressed slices take; 1 if none is compressed.
    double packing() const;
    /// Returns slice z and the slices that its gradients come from. An owned slab touches z, and
    /// either slices are still arriving or gradients are not stored, so all of them are stored.
    SliceNeighbors neighbors(int z) const;
    std::size_t memory_bytes() const { return charged_bytes_; }
    StoreCounts counts() const;

  private:
    void begin_packing(std::size_t peak);
    void charge(std::size_t bytes, int z);
    void unpack(int z, HeldSlice& slice) const;
    void add_gradients(int z);
    void discard_done(int z);

    VolumeShape shape_;
    Share share_;
    LocalMemory& memory_;
    std::vector<int> slabs_, needed_;
    std::size_t next_ = 0;                     ///< Index into needed_ of the next slice to come.
    mutable std::map<int, HeldSlice> slices_;  ///< slice() restores values.
    std::size_t charged_bytes_ = 0;
    std::unique_ptr<SlicePacker> packer_;  ///< Null unless the slices are compressed.
    std::size_t packed_bytes_ = 0;
    std::vector<std::byte> arriving_;    ///< The slice that is compressed.
    mutable std::vector<int> unpacked_;  ///< Slices with values, the last used one at the end.
};

}  // namespace pxpl5::gp
