// Pictures: what is shown. One of several samples a pixel is as many frames, its passes.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "host/timing/simulate.hpp"

namespace pxpl5::host::timing {

/// The passes of a picture, which the run asks for one behind the other.
struct Picture {
    std::size_t step = 0;  ///< Of the first, in RunWork::steps.
    std::vector<const FrameWork*> passes;
};

/// The run's pictures in their order. One that was given up, or whose passes could not all be
/// counted, is left out. They hold addresses of the run's frames.
std::vector<Picture> pictures_of(const RunWork& run);

/// The picture that has a pass at that step; nothing if there is none.
std::optional<Picture> picture_at(const RunWork& run, std::size_t step);

/// Its passes one behind the other, over and over: pictures a second, latency from the command of
/// the first pass to the host's knowledge of the last. Throws as simulate().
Rate picture_rate(const Machine& machine, const Picture& picture);

}  // namespace pxpl5::host::timing
