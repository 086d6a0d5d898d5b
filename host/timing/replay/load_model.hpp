// A volume's way to the GPs, and its gradients.
#pragma once

#include <vector>

#include "host/timing/counts/work.hpp"
#include "host/timing/replay/hardware.hpp"

namespace pxpl5::host::timing {

/// Source: README.md, "Load".
class LoadModel {
  public:
    explicit LoadModel(Hardware& hardware) : hardware_(hardware) {}

    /// `done` is called when the host knows that all GPs have their gradients. One at a time.
    void start(const VolumeWork& volume, Callback<> done);

  private:
    void take(std::uint32_t slice, std::uint32_t gp);
    void finish_set(std::uint32_t gp);
    void ready();

    Hardware& hardware_;
    Callback<> done_;
    Ns set_time_ = 0;
    std::vector<std::uint32_t> slices_due_;  ///< By slab, of its set.
    std::vector<std::uint32_t> sets_due_;    ///< By GP.
    std::uint32_t gps_due_ = 0;
};

}  // namespace pxpl5::host::timing
