// The extraction of a surface on all GPs.
#pragma once

#include <vector>

#include "host/timing/counts/work.hpp"
#include "host/timing/replay/hardware.hpp"

namespace pxpl5::host::timing {

/// Edges that extraction looks at in a slab, with those of the last slice if it is the last slab.
std::uint64_t edges_of(const VolumeWork& volume, std::uint32_t slab);

/// Source: README.md, "Build".
class BuildModel {
  public:
    explicit BuildModel(Hardware& hardware) : hardware_(hardware) {}

    /// `done` is called when the host knows that all GPs have built theirs. One at a time.
    void start(const BuildWork& build, const VolumeWork& volume, Callback<> done);

  private:
    struct Duty {
        Ns time = 0;
        std::uint64_t slabs = 0, triangles = 0;
        std::size_t messages_due = 0;  ///< From other GPs.
        bool extracted = false;
    };

    /// Triangles of `from` that `to` takes over, or keeps.
    std::uint64_t given(std::size_t from, std::size_t to) const;
    void extracted(std::size_t gp);
    void received(std::size_t gp);
    void answer_if_done(std::size_t gp);
    void built();

    Hardware& hardware_;
    Callback<> done_;
    std::vector<Duty> duties_;  ///< By GP.
    std::size_t gps_due_ = 0;
};

}  // namespace pxpl5::host::timing
