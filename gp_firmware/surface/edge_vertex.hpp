// A vertex where the surface crosses the edge between two voxels.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "gp_firmware/surface/mesh.hpp"
#include "gp_firmware/volume/gradient.hpp"

namespace pxpl5::gp {

/// Converts gradients per voxel step to normals in patient axes.
class NormalFrame {
  public:
    NormalFrame() = default;
    /// voxel_to_patient  A matrix with an invertible 3x3 part.
    explicit NormalFrame(const glm::dmat4& voxel_to_patient) {
        const glm::dmat3 m = -glm::transpose(glm::inverse(glm::dmat3(voxel_to_patient)));
        double greatest = 0;
        for (int c = 0; c < 3; ++c) {
            for (int r = 0; r < 3; ++r) {
                greatest = std::max(greatest, std::abs(m[c][r]));
            }
        }
        // Only directions matter: entries of at most 1 keep squares in range.
        for (int c = 0; c < 3; ++c) {
            columns_[static_cast<std::size_t>(c)] = m[c] / greatest;
        }
    }

    /// Returns the outward direction of a gradient. A gradient points inward.
    glm::vec3 outward(glm::vec3 gradient) const {
        return columns_[0] * gradient.x + columns_[1] * gradient.y + columns_[2] * gradient.z;
    }

    const glm::vec3& column(std::size_t c) const { return columns_[c]; }

  private:
    std::array<glm::vec3, 3> columns_{};
};

/// Returns the unit vector along n in steps of 1 / normal_one.
inline std::array<std::int16_t, 3> pack_normal(glm::vec3 n, float length_squared) {
    const float factor = normal_one / std::sqrt(length_squared);
    const auto pack = [factor](float component) {
        const float scaled = component * factor;
        return static_cast<std::int16_t>(scaled + std::copysign(0.5F, scaled));
    };
    return {pack(n.x), pack(n.y), pack(n.z)};
}

/// The two ends of a crossed edge, lower voxel first. The order is fixed, so that two slabs (or
/// GPs) that share an edge compute the same bits.
struct EdgeEnds {
    double value_0, value_1;
    Gradient gradient_0, gradient_1;
    float z_factor_0, z_factor_1;  ///< z_factor() of the ends' slices.
};

/// Returns the factor from a difference along z in slice z to a difference over two steps of the
/// grid. It is 1 if the slices above and below are one step away.
inline float z_factor(const VolumeShape& shape, int z) {
    const int below = std::max(z - 1, 0), above = std::min(z + 1, shape.nz - 1);
    // At the volume's ends the one-sided difference is already doubled.
    return static_cast<float>((above - below) / (shape.place(above) - shape.place(below)));
}

/// Returns the place where the surface crosses the edge, from 0 at the lower voxel to 1. Returns
/// the middle if infinite values give no number.
inline double crossing(double value_0, double value_1, double isovalue) {
    const double t = (isovalue - value_0) / (value_1 - value_0);
    return t >= 0 && t <= 1 ? t : 0.5;
}

/// If the gradients cancel out, the normal is that of a gradient along the edge, which depends only
/// on the edge.
inline std::array<std::int16_t, 3> edge_normal(const EdgeEnds& ends, float t, int axis,
                                               double isovalue, const NormalFrame& frame) {
    glm::vec3 gradient;
    for (int i = 0; i < 3; ++i) {
        auto g_0 = static_cast<float>(ends.gradient_0[static_cast<std::size_t>(i)]);
        auto g_1 = static_cast<float>(ends.gradient_1[static_cast<std::size_t>(i)]);
        if (i == 2) {
            g_0 *= ends.z_factor_0;
            g_1 *= ends.z_factor_1;
        }
        gradient[i] = g_0 + t * (g_1 - g_0);
    }
    glm::vec3 n = frame.outward(gradient);
    float length_squared = n.x * n.x + n.y * n.y + n.z * n.z;
    if (!(length_squared > 0)) {
        gradient = glm::vec3(0);
        gradient[axis] = ends.value_0 >= isovalue ? -1.0F : 1.0F;
        n = frame.outward(gradient);
        length_squared = n.x * n.x + n.y * n.y + n.z * n.z;
    }
    return pack_normal(n, length_squared);
}

}  // namespace pxpl5::gp
