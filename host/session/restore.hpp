// Restores a session's scene.
#pragma once

#include "host/session/session.hpp"

namespace pxpl5::host {

/// Gives the session the parameters of `wanted`: camera, lights, material, background, clips, tint
/// and surfaces. Extracts only surfaces with a changed isovalue or table. Keeps the picture's size,
/// samples and overlay. Throws RequestError, MachineError; some parameters may be set then.
void restore(Session& session, const Scene& wanted);

/// Calls restore(), and restores size, samples and overlay of the picture, for example after a
/// death.
void restore_all(Session& session, const Scene& wanted);

}  // namespace pxpl5::host
