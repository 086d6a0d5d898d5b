// What a session asked of its machine, for the model. Counted by the nodes, told in messages and
// put together in a fixed order: it does not depend on how many nodes there are.
#pragma once

#include <string>
#include <vector>

#include "host/session/session.hpp"
#include "host/timing/counts/work.hpp"

namespace pxpl5::host {

/// The volume that is loaded. Throws RequestError if there is none.
timing::VolumeWork volume_work(const Session& session);

/// The newest extraction of a surface. Throws RequestError if there is none of that name.
timing::BuildWork build_work(const Session& session, const std::string& surface);

/// Draws the scene once and drops the picture: one frame for each sample a pixel.
/// Throws RequestError (failed) as drawing does.
std::vector<timing::FrameWork> frame_work(Session& session);

/// The volume, if there is one, the builds of all surfaces in drawing order, the scene's frame.
/// Throws as frame_work().
timing::RunWork live_work(Session& session);

}  // namespace pxpl5::host
