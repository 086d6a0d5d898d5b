// Puts a session's scene back as it was.
#pragma once

#include "host/session/session.hpp"

namespace pxpl5::host {

/// Gives the session the parameters of `wanted`: camera, lights, material, background, clips, tint
/// and surfaces, of which only those are extracted again whose isovalue or table differs. Size,
/// samples and overlay of the picture stay. Throws RequestError, MachineError; then some of it may
/// be done.
void restore(Session& session, const Scene& wanted);

/// restore(), and size, samples and overlay of the picture: all of the scene, as after a death.
void restore_all(Session& session, const Scene& wanted);

}  // namespace pxpl5::host
