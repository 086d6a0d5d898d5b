// Slices of a volume with their gray values, as radiologists show them, and where surfaces cut
// them.
#pragma once

#include <array>
#include <cstddef>
#include <glm/vec2.hpp>
#include <span>
#include <string>
#include <vector>

#include "host/scene/scene.hpp"
#include "host/volume/volume.hpp"

namespace pxpl5::host {

/// One direction of a slice's picture: to the right, or downwards.
struct SliceSide {
    int axis = 0;             ///< Axis of the voxels, 0 x .. 2 z.
    bool is_flipped = false;  ///< The picture begins with the axis' last voxel.
    int count = 0;            ///< Voxels.
    double spacing_mm = 1;    ///< Between neighbors; where these are unevenly spaced, the mean.
    /// Middles of all voxels, counted from the first that the picture shows; empty if they are
    /// evenly spaced.
    std::vector<double> places_mm;
    std::string begin, end;  ///< Letters of the patient's direction there: "R", "LA".

    /// Middle of voxel `number`, counted along the picture, from the first one's.
    double place_mm(double number) const;
    /// The inverse of place_mm().
    double number_at(double place_mm) const;
};

/// How slices across an axis stand. The patient's left is on the picture's right and anterior on
/// top in slices that are nearest to axial; left is right and superior on top in coronal ones;
/// posterior is right and superior on top in sagittal ones.
struct SliceFrame {
    SliceSide across, down;
    int through = 2;      ///< The axis.
    double skew_deg = 0;  ///< 90 less the angle between the sides, for a tilted gantry.
};

/// A gantry's tilt is reported above this angle.
inline constexpr double max_skew_deg = 0.5;

/// axis  0 x, 1 y, 2 z.
SliceFrame slice_frame(const Volume& volume, int axis);

/// A slice's values, row by row as the picture shows them.
struct Slice {
    SliceFrame frame;
    Scalar type = Scalar::int16;
    std::vector<std::byte> values;  ///< across.count * down.count, little endian, of `type`.
};

/// Returns the nearest slice at or below `index` of the copy that the host keeps, which has every
/// n-th voxel (host/volume/reduced.hpp), or the slice itself if the host keeps all voxels.
/// index  0 .. voxels along the axis - 1 (asserted).
Slice slice_of(const Volume& whole, int axis, int index);

/// Returns the slice whose voxels are `values`, for a volume whose values the host does not keep.
/// values  All voxels of the slice, of volume.type: x fastest, then y, then z (size asserted).
Slice slice_of_plane(const Volume& volume, int axis, std::span<const std::byte> values);

/// A slice's values as numbers.
std::vector<double> numbers_of(const Slice& slice);

/// A piece of a contour, in slice pixels: the middle of the first pixel is (0, 0), x to the right
/// and y downwards.
struct ContourPiece {
    glm::vec2 from{0}, to{0};
};

/// Contours in a square of four voxels of which two opposite voxels are inside.
enum class SaddleRule : std::uint8_t {
    apart,      ///< Its inside corners are parted.
    asymptotic  ///< They are joined if the saddle of the bilinear interpolation is inside.
};
/// The rule of a surface, because a slice lies on faces of its cells. If the cells on both sides
/// disagree (lorensen1987), the inside corners are separated.
SaddleRule saddle_rule(CaseRule table);

/// Where the isovalue cuts the slice, by marching squares: inside is value >= isovalue, and between
/// two voxels the value is linear, as in extraction (gp_firmware/surface). The inside is on the
/// right of each piece as one sees the picture.
///
/// numbers  As numbers_of(slice).
/// Source:  Nielson and Hamann, The Asymptotic Decider, 1991.
std::vector<ContourPiece> slice_contour(const SliceFrame& frame, const std::vector<double>& numbers,
                                        double isovalue, SaddleRule rule);

}  // namespace pxpl5::host
