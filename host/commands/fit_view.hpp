// Fits the view to the surfaces.
#pragma once

#include <span>

#include "host/session/session.hpp"

namespace pxpl5::host {

/// `camera` with the zoom and pan that show all visible surfaces whole: the box of all voxels at or
/// above the least isovalue; without surfaces, the volume.
Camera fitted_to_surfaces(const Volume& volume, std::span<const Surface> surfaces,
                          const Camera& camera);

/// The same for the scene of a session. An archive fills its sphere, so its camera stays.
Camera fitted_to_surfaces(const Session& session, const Camera& camera);

}  // namespace pxpl5::host
