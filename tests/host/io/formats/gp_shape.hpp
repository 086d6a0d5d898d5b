// The shape of a volume as a GP gets it.
#pragma once

#include "gp_firmware/volume/slice.hpp"
#include "host/volume/volume.hpp"

namespace pxpl5::test {

inline gp::VolumeShape shape_of(const host::Volume& volume) {
    gp::VolumeShape shape;
    shape.nx = volume.nx;
    shape.ny = volume.ny;
    shape.nz = volume.nz;
    shape.type = volume.type;
    return shape;
}

}  // namespace pxpl5::test
