// Distances to shapes, as callables (x, y, z) in mm -> mm.
#pragma once

#include <algorithm>
#include <cmath>

#include "host/phantom/field.hpp"

namespace pxpl5::host::phantom {

inline constexpr float tiny =
    1e-4F;  ///< Keeps a division by zero out of the middle of an ellipsoid.

/// Distance to a rod from a point relative to its first end.
struct RodDistance {
    glm::vec3 a, ab;
    float inverse_square, a_radius, growth;

    explicit RodDistance(const Rod& rod)
        : a(rod.a_mm),
          ab(rod.b_mm - rod.a_mm),
          inverse_square(1 / std::max(ab.x * ab.x + ab.y * ab.y + ab.z * ab.z, tiny)),
          a_radius(rod.a_radius_mm),
          growth(rod.b_radius_mm - rod.a_radius_mm) {}

    float operator()(float x, float y, float z) const {
        const float px = x - a.x, py = y - a.y, pz = z - a.z;
        const float along = (px * ab.x + py * ab.y + pz * ab.z) * inverse_square;
        const float t = std::min(std::max(along, 0.0F), 1.0F);
        const float qx = px - t * ab.x, qy = py - t * ab.y, qz = pz - t * ab.z;
        return std::sqrt(qx * qx + qy * qy + qz * qz) - (a_radius + t * growth);
    }
};

/// First-order distance to an ellipsoid: exact on the surface, right in sign.
struct BallDistance {
    glm::vec3 center, inverse_radius;
    glm::mat3 to_axes;  ///< Columns, as glm keeps them.
    float least_radius;

    explicit BallDistance(const Ball& ball)
        : center(ball.center_mm),
          inverse_radius(1.0F / ball.radius_mm.x, 1.0F / ball.radius_mm.y, 1.0F / ball.radius_mm.z),
          to_axes(turned(ball.tilt_deg)),
          least_radius(std::min({ball.radius_mm.x, ball.radius_mm.y, ball.radius_mm.z})) {}

    float operator()(float x, float y, float z) const {
        const float px = x - center.x, py = y - center.y, pz = z - center.z;
        // The transpose of a rotation is its inverse.
        const float ax =
            (to_axes[0].x * px + to_axes[0].y * py + to_axes[0].z * pz) * inverse_radius.x;
        const float ay =
            (to_axes[1].x * px + to_axes[1].y * py + to_axes[1].z * pz) * inverse_radius.y;
        const float az =
            (to_axes[2].x * px + to_axes[2].y * py + to_axes[2].z * pz) * inverse_radius.z;
        const float bx = ax * inverse_radius.x, by = ay * inverse_radius.y,
                    bz = az * inverse_radius.z;
        const float reach = std::sqrt(ax * ax + ay * ay + az * az);
        const float slope = std::sqrt(bx * bx + by * by + bz * bz);
        return (reach - 1) * (reach + tiny * least_radius) / (slope + tiny);
    }
};

/// Distance to a strand: its two halves, rounded where they meet.
struct StrandDistance {
    RodDistance upper, lower;

    explicit StrandDistance(const Strand& s)
        : upper({s.from.p_mm, s.from.radius_mm, s.belly.p_mm, s.belly.radius_mm}),
          lower({s.belly.p_mm, s.belly.radius_mm, s.to.p_mm, s.to.radius_mm}) {}

    float operator()(float x, float y, float z) const {
        return smooth_min(upper(x, y, z), lower(x, y, z), strand_blend_mm, 0.25F / strand_blend_mm);
    }
};

}  // namespace pxpl5::host::phantom
