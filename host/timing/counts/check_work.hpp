// Whether a run's counts can be replayed.
#pragma once

#include "host/timing/counts/work.hpp"

namespace pxpl5::host::timing {

/// Throw RequestError (bad_data) that names what, where and both values.
void check_frame(const FrameWork& frame);
void check_volume(const VolumeWork& volume);
/// `volume`: the one that was loaded last, or null.
void check_build(const BuildWork& build, const VolumeWork* volume);
/// Checks that the run was drawn by this number of Renderers.
void check_assignment(const FrameWork& frame, std::uint32_t renderers);

}  // namespace pxpl5::host::timing
