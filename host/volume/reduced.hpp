// The copy of a volume that the host keeps if the GPs read the values themselves.
#pragma once

#include <cstddef>
#include <string>

#include "host/volume/volume.hpp"

namespace pxpl5::host {

/// Voxels of `count` that remain if every n-th one is kept, from 0.
inline int kept_of(int count, int reduction) {
    return (count + reduction - 1) / reduction;
}

/// A volume of every n-th voxel, without values. It lies at the same place in the patient.
inline Volume reduced_shape(const Volume& volume, int reduction) {
    Volume out;
    out.name = volume.name;
    out.nx = kept_of(volume.nx, reduction);
    out.ny = kept_of(volume.ny, reduction);
    out.nz = kept_of(volume.nz, reduction);
    out.type = volume.type;
    out.voxel_to_patient = volume.voxel_to_patient;
    for (int axis = 0; axis < 3; ++axis) {
        out.voxel_to_patient[axis] *= reduction;
    }
    out.minimum = volume.minimum;
    out.maximum = volume.maximum;
    out.modality = volume.modality;
    out.unit = volume.unit;
    out.windows = volume.windows;
    out.suv_per_value = volume.suv_per_value;
    out.source = volume.source;
    return out;
}

/// The volume whose values the host has: `volume` itself, or its reduced copy.
inline const Volume& kept(const Volume& volume) {
    return volume.reduced ? *volume.reduced : volume;
}

/// Throws RequestError (failed) if the host has only a reduced copy, which `what` cannot use.
void require_all_voxels(const Volume& volume, const std::string& what);

}  // namespace pxpl5::host
