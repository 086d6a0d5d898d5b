// Whether two volumes are the same one: voxels, place in the patient, series.
#pragma once

#include <cstdint>
#include <string>

#include "host/volume/volume.hpp"

namespace pxpl5::host {

/// Digest of the number of voxels, of voxel_to_patient and of the slices' places: lengths that are
/// measured in two volumes can be compared only if it is the same.
std::uint64_t place_digest(const Volume& volume);

/// Differs between volumes that differ in voxels, place or series.
std::string identity_of(const Volume& volume);

/// The same for all volumes of a time series that were loaded at once, else identity_of().
/// load  Number of the load.
std::string series_identity_of(const Volume& volume, int load);

}  // namespace pxpl5::host
