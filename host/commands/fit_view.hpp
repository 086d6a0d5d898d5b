// Fits the view to the surfaces.
#pragma once

#include "host/session/session.hpp"

namespace pxpl5::host {

/// The session's camera with the zoom and pan that show all visible surfaces whole: the box of all
/// voxels at or above the least isovalue; without surfaces, the volume.
Camera fitted_to_surfaces(const Session& session, const Camera& camera);

}  // namespace pxpl5::host
