// Where a volume lies in the patient: spacing that files leave out, and what is odd.
#pragma once

#include <array>
#include <glm/mat4x4.hpp>
#include <string>

#include "host/io/values/import_request.hpp"
#include "host/volume/volume.hpp"

namespace pxpl5::host::io {

/// The same place in LPS of a place in RAS.
glm::dmat4 to_lps(glm::dmat4 ras);

/// Gives the axes that have no spacing of the file's the one that is asked for, or 1 mm as a
/// reported assumption.
/// stated   Of each axis.
/// Throws   ImportError if spacing is asked for and the file states all of it.
void take_spacing(const std::string& file, const ImportRequest& request,
                  const std::array<bool, 3>& stated, Volume& volume);

/// Turns the axes of a file that states no orientation to the one that is asked for, or reports
/// `assumption` about its axes.
/// assumption  Text of the finding; empty for a file that states its orientation.
/// Throws      ImportError if an orientation or origin is asked for and the file states one.
void take_directions(const std::string& file, const ImportRequest& request,
                     const std::string& assumption, Volume& volume);

/// Reports shear and reflection.
/// Throws   ImportError: the affine is not finite, its axes span no volume, or voxels lie closer,
///          farther apart or farther away than the machine takes.
void check_place(const std::string& file, Volume& volume);

}  // namespace pxpl5::host::io
