// Sphere set-up: the image of a sphere on the screen. Its outline, its depth and its normal are
// exact functions of the pixel: a quadratic form, and planes with the root of that form.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "gp_firmware/geometry/bin.hpp"
#include "gp_firmware/geometry/transform.hpp"

namespace pxpl5::gp {

/// c + a u + b v, where (u, v) is a pixel's center minus the sphere's center, in pixels.
struct ScreenPlane {
    double a = 0, b = 0, c = 0;
};

/// A sphere in front of the eye. At the pixel (u, v), with S = sqrt(form(u, v)) in 0..1:
///     inside if form >= 0;  depth = depth_plane - depth_root S;
///     normal[k] = normal_plane[k] - normal_root[k] S, not normalized, normal_unit at most.
struct ScreenSphere {
    double x_px = 0, y_px = 0;  ///< Projection of the center.
    /// form = f[0] + f[1] u + f[2] v + f[3] u u + f[4] u v + f[5] v v: 1 in the ellipse's middle,
    /// 0 on the outline.
    std::array<double, 6> form{};
    ScreenPlane depth_plane;
    double depth_root = 0;  ///< Depth from the outline's plane to the nearest point.
    std::array<ScreenPlane, 3> normal_plane;
    std::array<double, 3> normal_root{};
    PixelBox box;  ///< Pixels of the picture that the sphere may cover.
};

/// Returns the image of a sphere. Returns nothing if no pixel center lies in the bounding box, or
/// if the sphere is not wholly in front of the eye, between the near and far planes, and on the
/// inner side of all clip planes.
///
/// Source  A quadric's image under a projective map; ours.
std::optional<ScreenSphere> screen_sphere(const Sphere& sphere, const Projection& projection,
                                          const RegionGrid& grid);

/// Returns the form at (u, v).
inline double form_at(const std::array<double, 6>& f, double u, double v) {
    return f[0] + (f[1] + f[3] * u) * u + (f[2] + f[5] * v) * v + f[4] * u * v;
}

}  // namespace pxpl5::gp
