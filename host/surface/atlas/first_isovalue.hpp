// An isovalue for a volume without a stated isovalue.
#pragma once

#include "host/volume/volume.hpp"

namespace pxpl5::host {

/// The value that parts the voxels best in two classes; between whole numbers if they are such.
/// The volume's least value if all are equal.
/// Source  N. Otsu, A threshold selection method from gray-level histograms, IEEE Trans. SMC 1979.
double first_isovalue(const Volume& volume);

}  // namespace pxpl5::host
