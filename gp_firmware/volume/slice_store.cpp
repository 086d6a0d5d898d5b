#include "gp_firmware/volume/slice_store.hpp"

#include <algorithm>
#include <cassert>
#include <stdexcept>
#include <string>
#include <utility>

namespace pxpl5::gp {

namespace {

void check_shape(const VolumeShape& shape) {
    if (std::min({shape.nx, shape.ny, shape.nz}) >= 2) {
        return;
    }
    throw std::invalid_argument("a volume needs 2 voxels along each axis, has " +
                                std::to_string(shape.nx) + "x" + std::to_string(shape.ny) + "x" +
                                std::to_string(shape.nz));
}

void check_share(Share share) {
    const bool count_ok = share.gp_count >= 1 && share.gp_count <= max_nodes_per_role;
    if (count_ok && share.gp_index >= 0 && share.gp_index < share.gp_count) {
        return;
    }
    throw std::invalid_argument("GP " + std::to_string(share.gp_index) + " of " +
                                std::to_string(share.gp_count) + ": there are 1 to " +
                                std::to_string(max_nodes_per_role) + " GPs, counted from 0");
}

}  // namespace

SliceStore::SliceStore(const VolumeShape& shape, Share share, LocalMemory& memory)
    : shape_(shape), share_(share), memory_(memory) {
    check_shape(shape);
    check_share(share);
    slabs_ = slabs_owned(shape, share);
    needed_ = slices_needed(shape, share);
    const std::size_t peak = peak_bytes(shape, share);
    if (peak > memory.available_bytes()) {
        begin_packing(peak);
    }
}

/// Throws OutOfLocalMemory if the slices cannot fit even if they are compressed well.
void SliceStore::begin_packing(std::size_t peak) {
    if (shape_.holds_gradients() ||
        packed_peak_bytes(shape_, share_, best_packing) > memory_.available_bytes()) {
        throw OutOfLocalMemory("the slices of GP " + std::to_string(share_.gp_index) + " of " +
                                   std::to_string(share_.gp_count),
                               peak, memory_.available_bytes(),
                               gp_count_advice(shape_, memory_.size_bytes()));
    }
    packer_ = std::make_unique<SlicePacker>(size_bytes(shape_.type));
    charge(max_unpacked_slices * shape_.slice_voxels() * size_bytes(shape_.type), needed_.front());
}

SliceStore::~SliceStore() {
    memory_.release(charged_bytes_);
}

double SliceStore::packing() const {
    const std::size_t raw_bytes = next_ * shape_.slice_voxels() * size_bytes(shape_.type);
    return packed_bytes_ == 0 ? 1
                              : static_cast<double>(packed_bytes_) / static_cast<double>(raw_bytes);
}

void SliceStore::charge(std::size_t bytes, int z) {
    const bool fits = bytes <= memory_.available_bytes();  // Advice takes time to compute.
    memory_.charge(
        bytes, "slice " + std::to_string(z) + (packer_ ? ", compressed" : ""),
        fits ? std::string() : gp_count_advice(shape_, memory_.size_bytes(), 0, packing()));
    charged_bytes_ += bytes;
}

void SliceStore::add_slice(int z, std::span<const std::byte> values) {
    if (complete()) {
        throw std::invalid_argument("slice " + std::to_string(z) +
                                    " arrived, but the GP has all of its slices");
    }
    if (z != needed_[next_]) {
        throw std::invalid_argument("slice " + std::to_string(z) + " arrived, but slice " +
                                    std::to_string(needed_[next_]) + " is next");
    }
    const std::size_t expected = shape_.slice_voxels() * size_bytes(shape_.type);
    if (values.size() != expected) {
        throw std::invalid_argument("slice " + std::to_string(z) + " needs " +
                                    std::to_string(expected) + " bytes, has " +
                                    std::to_string(values.size()));
    }
    if (!packer_) {
        charge(values.size(), z);
    }
    HeldSlice& slice = slices_[z];
    // One buffer for all slices: freed slices between compressed ones would not be used again.
    std::vector<std::byte>& whole = packer_ ? arriving_ : slice.values;
    whole.assign(values.begin(), values.end());
    if (is_own(shape_, share_, z)) {
        slice.rows = index_rows(shape_, whole);
        charge(slice.rows.size_bytes(), z);
    }
    if (packer_) {
        slice.packed = packer_->pack(whole);
        charge(slice.packed.size(), z);
        packed_bytes_ += slice.packed.size() + slice.rows.size_bytes();
    }
    ++next_;
    if (shape_.holds_gradients()) {
        if (z > 0) {
            add_gradients(z - 1);
        }
        if (z == shape_.nz - 1) {
            add_gradients(z);
        }
    }
    discard_done(z);
    if (packer_ && complete()) {
        arriving_ = {};
        packer_->end_packing();
    }
}

/// Estimates the gradients of slice z if it is kept. Its neighbors have arrived.
void SliceStore::add_gradients(int z) {
    if (!is_own(shape_, share_, z)) {
        return;
    }
    charge(shape_.slice_voxels() * sizeof(Gradient), z);
    slices_.at(z).gradients = estimate_gradients(shape_, neighbors(z));
}

SliceNeighbors SliceStore::neighbors(int z) const {
    const int below = std::max(z - 1, 0), above = std::min(z + 1, shape_.nz - 1);
    return {slice(below).values, slice(z).values, slice(above).values, below == z || above == z};
}

/// Discards the slices that are not needed after the arrival of slice z.
void SliceStore::discard_done(int z) {
    const std::size_t freed = std::erase_if(slices_, [&](const auto& held) {
        return discarded_after(shape_, share_, held.first) == z;
    });
    const std::size_t bytes = freed * shape_.slice_voxels() * size_bytes(shape_.type);
    memory_.release(bytes);
    charged_bytes_ -= bytes;
}

std::vector<int> SliceStore::held() const {
    std::vector<int> numbers;
    for (const auto& held : slices_) {
        numbers.push_back(held.first);
    }
    return numbers;
}

StoreCounts SliceStore::counts() const {
    StoreCounts counts;
    counts.slices = static_cast<std::uint32_t>(next_);
    for (const auto& [z, slice] : slices_) {
        counts.runs += slice.rows.runs.size();
        for (std::size_t y = 0; y + 1 < slice.rows.run_first.size(); ++y) {
            counts.rows_in_runs += slice.rows.run_first[y] < slice.rows.run_first[y + 1] ? 1 : 0;
        }
    }
    return counts;
}

const HeldSlice& SliceStore::slice(int z) const {
    const auto found = slices_.find(z);
    assert(found != slices_.end());
    if (packer_) {
        unpack(z, found->second);
    }
    return found->second;
}

/// Restores the values. They take the place of those that were used longest ago.
void SliceStore::unpack(int z, HeldSlice& slice) const {
    std::erase(unpacked_, z);
    if (slice.values.empty()) {
        if (unpacked_.size() == max_unpacked_slices) {
            slice.values = std::exchange(slices_.at(unpacked_.front()).values, {});
            unpacked_.erase(unpacked_.begin());
        }
        slice.values.resize(shape_.slice_voxels() * size_bytes(shape_.type));
        try {
            packer_->unpack(slice.packed, slice.values);
        } catch (...) {
            slice.values = {};  // Else the next use would take them for the values.
            throw;
        }
    }
    unpacked_.push_back(z);
}

}  // namespace pxpl5::gp
