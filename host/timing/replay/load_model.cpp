#include "host/timing/replay/load_model.hpp"

#include <algorithm>

namespace pxpl5::host::timing {

namespace {

constexpr std::uint64_t ready_words = 8;
constexpr std::uint64_t word_bytes = 4;
constexpr std::uint32_t kept_slices = 2;

/// Slabs whose sets hold a slice: a set is a slab's two slices and one to each side.
struct SlabRange {
    std::uint32_t first, end;
};
SlabRange slabs_with(std::uint32_t slice, std::uint32_t slabs) {
    return {slice < 2 ? 0 : slice - 2, std::min(slice + 2, slabs)};
}

/// Cycles for one voxel's gradient. A smooth one (gp_firmware/volume/smooth_gradient.hpp) has 26
/// additions, subtractions and doublings instead of 3: 19 of its next column and 7 of the columns,
/// whose parts stay in registers. It reads the 9 voxels of the column instead of 6. Each of the
/// further ones takes a cycle.
double gradient_cycles(const Machine& machine, GradientKernel kernel) {
    constexpr double further_operations = 26 - 3, further_reads = 9 - 6;
    return machine.gp_gradient_cycles +
           (kernel == GradientKernel::smooth ? further_operations + further_reads : 0);
}

}  // namespace

void LoadModel::start(const VolumeWork& volume, Callback<> done) {
    const auto gps = static_cast<std::uint32_t>(hardware_.gps.size());
    const std::uint32_t slabs = volume.nz - 1;
    const std::uint64_t voxels = std::uint64_t{volume.nx} * volume.ny;
    done_ = done;
    set_time_ = hardware_.costs.gp(static_cast<double>(kept_slices * voxels) *
                                   gradient_cycles(hardware_.machine, volume.gradient));
    slices_due_.assign(slabs, 0);
    sets_due_.assign(gps, 0);
    for (std::uint32_t slab = 0; slab < slabs; ++slab) {
        ++sets_due_[slab % gps];
    }
    gps_due_ = std::min(gps, slabs);
    if (gps_due_ == 0) {
        done_();
        return;
    }
    const std::uint64_t words = (voxels * volume.voxel_bytes + word_bytes - 1) / word_bytes;
    for (std::uint32_t slice = 0; slice < volume.nz; ++slice) {
        const SlabRange range = slabs_with(slice, slabs);
        // Slabs of one GP are as far apart as there are GPs: a GP's first one sends for all.
        for (std::uint32_t slab = range.first; slab < range.end; ++slab) {
            ++slices_due_[slab];
            if (slab >= range.first + gps) {
                continue;
            }
            hardware_.mail.send(hardware_.places.host(), hardware_.places.gp(slab % gps), words,
                                [this, slice, gp = slab % gps] { take(slice, gp); });
        }
    }
}

void LoadModel::take(std::uint32_t slice, std::uint32_t gp) {
    const auto gps = static_cast<std::uint32_t>(hardware_.gps.size());
    const SlabRange range = slabs_with(slice, static_cast<std::uint32_t>(slices_due_.size()));
    for (std::uint32_t slab = range.first; slab < range.end; ++slab) {
        if (slab % gps == gp && --slices_due_[slab] == 0) {
            hardware_.gps[gp].work(set_time_, [this, gp] { finish_set(gp); });
        }
    }
}

void LoadModel::finish_set(std::uint32_t gp) {
    if (--sets_due_[gp] == 0) {
        hardware_.mail.send(hardware_.places.gp(gp), hardware_.places.host(), ready_words,
                            [this] { ready(); });
    }
}

void LoadModel::ready() {
    if (--gps_due_ == 0) {
        Callback<> done = done_;
        done();
    }
}

}  // namespace pxpl5::host::timing
