// Built-in volumes: computed from shape tables, the same to the bit on every machine.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "host/volume/volume.hpp"

namespace pxpl5::host {

/// An isosurface that is worth looking at.
struct PhantomSurface {
    std::string name;
    double isovalue = 0;                      ///< In the volume's own unit; ends in .5.
    std::array<std::uint8_t, 3> color_rgb{};  ///< sRGB.
    int paper_triangles = 0;  ///< Yoo & Chen, figures 3 to 7; 0 if not in the paper.
};

/// A length of the shape that a test can hold a mesh against.
struct PhantomLength {
    std::string name;
    double length_mm = 0;
};

/// Properties of a phantom before it is computed.
struct PhantomInfo {
    std::string name;  ///< With its prefix: "phantom:pelvis".
    std::string description;
    std::array<int, 3> dims{};  ///< Voxels along x, y and z.
    Scalar type = Scalar::int16;
    std::array<double, 3> spacing_mm{};
    std::vector<PhantomSurface> surfaces;  ///< The first is the one to show unasked.
    std::vector<PhantomLength> lengths;    ///< Empty unless the shape is analytic.
    int frames = 1;                        ///< Volumes of its time series.
    double frame_ms = 0;                   ///< From one volume to the next; 0 without a series.
};

/// All phantoms, in the order in which to list them.
std::vector<PhantomInfo> phantoms();

/// Whether `name` asks for a phantom, known or not.
bool is_phantom(std::string_view name);

/// The surfaces of the phantom of that name; empty for any other volume.
std::vector<PhantomSurface> suggested_surfaces(std::string_view volume_name);

/// Computes a phantom.
///
/// name     As in PhantomInfo::name.
/// frame    Number in the phantom's time series, from 1.
/// Returns  Voxels, and their place: x to the patient's left, y to the back, z to the head (LPS).
/// Throws   std::invalid_argument naming the known phantoms and the nearest, or `frame` and how
///          many volumes there are.
Volume make_phantom(std::string_view name, int frame = 1);

}  // namespace pxpl5::host
