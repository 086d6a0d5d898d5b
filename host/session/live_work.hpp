// The work of a session for the timing model. The nodes count it, and the host adds the counts in a
// fixed order, so that the sums do not depend on the number of nodes.
#pragma once

#include <string>
#include <vector>

#include "host/session/session.hpp"
#include "host/timing/counts/work.hpp"

namespace pxpl5::host {

/// The loaded volume. Throws RequestError if no volume is loaded.
timing::VolumeWork volume_work(const Session& session);

/// The newest extraction of a surface. Throws RequestError if the surface does not exist.
timing::BuildWork build_work(const Session& session, const std::string& surface);

/// Draws the scene once and drops the picture: one frame per sample of a pixel.
/// Throws RequestError (failed) as drawing does.
std::vector<timing::FrameWork> frame_work(Session& session);

/// The loaded volume, if any, the builds of all surfaces in drawing order, and the scene's frame.
/// Throws as frame_work().
timing::RunWork live_work(Session& session);

}  // namespace pxpl5::host
