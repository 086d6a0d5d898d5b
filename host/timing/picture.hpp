// Pictures. A picture of several samples per pixel has one frame, a pass, per sample.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "host/timing/simulate.hpp"

namespace pxpl5::host::timing {

/// The passes of a picture, one after the other.
struct Picture {
    std::size_t step = 0;  ///< Index of the first pass in RunWork::steps.
    std::vector<const FrameWork*> passes;
};

/// The run's pictures in their order. A dropped picture, or one whose passes could not all be
/// counted, is left out. They hold addresses of the run's frames.
std::vector<Picture> pictures_of(const RunWork& run);

/// The picture that has a pass at that step; nothing if there is none.
std::optional<Picture> picture_at(const RunWork& run, std::size_t step);

/// Repeats its passes: returns pictures per second, and the latency from the command of
/// the first pass to the host's knowledge of the last. Throws as simulate().
Rate picture_rate(const Machine& machine, const Picture& picture);

}  // namespace pxpl5::host::timing
