// Pick: the surface point under a pixel, from the depths that a frame read back.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>

#include "host/scene/camera.hpp"
#include "host/volume/volume.hpp"

namespace pxpl5::host {

/// A view as a frame showed it.
struct PickView {
    CameraMatrices camera;      ///< The frame's request (host/session/transfer/frame_request.cpp).
    int width = 0, height = 0;  ///< Pixels.
    std::span<const std::uint32_t> depths{};  ///< FrameDone's, of this view: width * height.
};

/// The point of a surface in the middle of a pixel.
struct Pick {
    int surface = 0;            ///< Index in the frame's list.
    std::uint32_t depth = 0;    ///< In the depth buffer; smaller is nearer.
    glm::dvec3 p_mm{0};         ///< Patient, LPS.
    glm::dvec3 p_grid{0};       ///< Grid position.
    glm::dvec3 p_voxel{0};      ///< Like the grid position, but z counts slices.
    double doubt_mm = 0;        ///< Half of what a step of depth is here, along the line of sight.
    bool is_in_volume = false;  ///< p_voxel lies between voxels.
    int x = 0, y = 0, z = 0;    ///< The nearest voxel; held at the volume's faces.
    std::optional<double> value;          ///< Value of that voxel, if the host has the values.
    std::optional<double> value_between;  ///< Interpolated from the eight voxels around.
};

/// The surface point at pixel (x, y), counted from the top left; nothing for the background.
///
/// volume   On which the frame's surfaces lie.
/// Throws RequestError (usage) for a pixel outside of the view.
std::optional<Pick> pick(const PickView& view, int x, int y, const Volume& volume);

/// The lowest voxel of the eight around the pick.
glm::ivec3 cell_around(const Pick& pick, const Volume& volume);

/// Sets the values of the pick.
/// volume  Only its shape is read.
/// cell    2 x 2 x 2 voxels with values: those of `volume` from cell_around() on.
void set_values(Pick& pick, const Volume& volume, const Volume& cell);

/// Value of a voxel that is there; the volume has its values.
double voxel_value(const Volume& volume, int x, int y, int z);

}  // namespace pxpl5::host
