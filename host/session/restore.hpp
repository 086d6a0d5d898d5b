// Restores a session's scene.
#pragma once

#include "host/session/session.hpp"

namespace pxpl5::host {

/// Gives the session the parameters of `wanted`: camera, lights, material, background, clips, tint
/// and surfaces. Extracts only surfaces with a changed isovalue or table. Keeps the picture's size,
/// samples and overlay. Throws RequestError, MachineError; some parameters may be set then.
void restore(Session& session, const Scene& wanted);

/// Shows volume `frame` of the loaded time series with the same surfaces and clip planes. Throws
/// RequestError (usage) if there is none. If it cannot be read, or its surfaces cannot be extracted
/// (RequestError), the former volume is shown again.
void show_frame(Session& session, int frame);

/// Calls restore() after something has failed or ended, without a cancel in between. Throws
/// RequestError (failed) if the scene cannot be restored; then the history knows its losses.
void go_back(Session& session, const Scene& wanted);

/// Calls restore(), and restores size, samples and overlay of the picture, for example after a
/// death.
void restore_all(Session& session, const Scene& wanted);

}  // namespace pxpl5::host
