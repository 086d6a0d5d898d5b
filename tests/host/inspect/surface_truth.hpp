// The contents of a picture of an isosurface, computed directly: every triangle of every cell in
// doubles, projected by the frame's matrices, and nothing but the corners snapped to 1/16 pixel.
//
// Only the table of cases comes from the firmware. The firmware transforms in floats, so a corner
// may be snapped to the adjacent 1/16 pixel, and depths be off by some steps: what lies so near
// to an edge, or to another triangle, is reported as possible but not as sure.
#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <glm/glm.hpp>
#include <vector>

#include "gp_firmware/surface/case_tables.hpp"
#include "host/inspect/why/why_not.hpp"
#include "host/volume/volume.hpp"
#include "tests/random_seed.hpp"

namespace pxpl5::test {

using host::inspect::TriangleName;

/// PXPL5_SEED, or `usual`; printed.
inline unsigned test_seed(unsigned usual) {
    const unsigned seed = seed_or(usual);
    MESSAGE("seed ", seed);
    return seed;
}

inline double voxel(const host::Volume& v, int x, int y, int z) {
    const std::size_t at = (static_cast<std::size_t>(z) * static_cast<std::size_t>(v.ny) +
                            static_cast<std::size_t>(y)) *
                               static_cast<std::size_t>(v.nx) +
                           static_cast<std::size_t>(x);
    const auto read = [&]<typename T>(T one) {
        std::memcpy(&one, v.values.data() + at * sizeof one, sizeof one);
        return static_cast<double>(one);
    };
    switch (v.type) {
        case Scalar::uint8:
            return read(std::uint8_t{});
        case Scalar::int16:
            return read(std::int16_t{});
        case Scalar::uint16:
            return read(std::uint16_t{});
        default:
            return read(float{});
    }
}

/// A corner may be snapped to the next step, so an edge may move as far.
inline constexpr double edge_tolerance_px = 1.0 / 16 * 1.5;
struct TrueTriangle {
    TriangleName name;
    std::array<glm::dvec3, 3> p_voxel;
    std::array<glm::dvec2, 3> p_px;  ///< Snapped.
    std::array<double, 3> z;         ///< Depth, 0..1.
    glm::dvec2 low_px, high_px;      ///< The box around p_px, with the tolerance of the edges.

    /// Twice the area in px^2; negative faces the eye if the volume is not mirrored.
    double area() const {
        const glm::dvec2 a = p_px[1] - p_px[0], b = p_px[2] - p_px[0];
        return a.x * b.y - a.y * b.x;
    }
    /// How far the point is inside all edges, px; negative outside.
    double inside(glm::dvec2 p) const {
        double least = 1e9;
        const double turn = area() < 0 ? -1 : 1;
        for (std::size_t k = 0; k < 3; ++k) {
            const glm::dvec2 a = p_px[k], edge = p_px[(k + 1) % 3] - a, to = p - a;
            const double cross = turn * (edge.x * to.y - edge.y * to.x);
            least = std::min(least, cross / std::max(glm::length(edge), 1e-9));
        }
        return least;
    }
    bool box_holds(glm::dvec2 p) const {
        return p.x >= low_px.x && p.x <= high_px.x && p.y >= low_px.y && p.y <= high_px.y;
    }
    double depth_at(glm::dvec2 p) const {
        const glm::dvec2 a = p_px[1] - p_px[0], b = p_px[2] - p_px[0], to = p - p_px[0];
        const double u = (to.x * b.y - to.y * b.x) / area(), v = (a.x * to.y - a.y * to.x) / area();
        return z[0] + u * (z[1] - z[0]) + v * (z[2] - z[0]);
    }
    /// Depth per pixel, at most.
    double steepness() const {
        const glm::dvec2 o = p_px[0];
        const double z0 = depth_at(o);
        return std::abs(depth_at(o + glm::dvec2(1, 0)) - z0) +
               std::abs(depth_at(o + glm::dvec2(0, 1)) - z0);
    }
};

/// One frame of one surface, from one eye.
struct TrueView {
    glm::dmat4 voxel_to_clip{1.0};
    int width = 0, height = 0;

    glm::dvec3 to_px(const glm::dvec3& p_voxel) const {
        const glm::dvec4 p = voxel_to_clip * glm::dvec4(p_voxel, 1);
        return {(p.x / p.w + 1) / 2 * width, (1 - p.y / p.w) / 2 * height, (p.z / p.w + 1) / 2};
    }
};

/// The place in the grid of what lies at z, counted in slices.
inline double grid_z(const host::Volume& volume, double z) {
    const auto slice = static_cast<std::size_t>(std::floor(z));
    if (volume.slice_places.empty() || slice + 1 >= volume.slice_places.size()) {
        return volume.slice_places.empty() ? z : volume.slice_places.back();
    }
    return std::lerp(volume.slice_places[slice], volume.slice_places[slice + 1],
                     z - static_cast<double>(slice));
}

/// All triangles, in the order in which they are drawn: slab by slab, row by row.
inline std::vector<TrueTriangle> true_triangles(const host::Volume& volume, double isovalue,
                                                const TrueView& view, std::uint32_t surface = 0) {
    const gp::CaseTable& table = gp::case_table(CaseRule::watertight);
    std::vector<TrueTriangle> all;
    for (int k = 0; k + 1 < volume.nz; ++k) {
        for (int j = 0; j + 1 < volume.ny; ++j) {
            for (int i = 0; i + 1 < volume.nx; ++i) {
                std::array<double, 8> value{};
                unsigned inside = 0;
                for (unsigned c = 0; c < 8; ++c) {
                    value[c] =
                        voxel(volume, i + static_cast<int>(c & 1), j + static_cast<int>(c >> 1 & 1),
                              k + static_cast<int>(c >> 2));
                    inside |= (value[c] >= isovalue ? 1U : 0U) << c;
                }
                const gp::CaseEntry& entry = table.entry(static_cast<std::uint8_t>(inside), 0);
                const auto corners = table.corners_of(entry);
                const auto on_edge = [&](int edge) {
                    const auto ends = gp::edge_corners(edge);
                    const double v0 = value[static_cast<std::size_t>(ends[0])];
                    const double v1 = value[static_cast<std::size_t>(ends[1])];
                    glm::dvec3 p(i + (ends[0] & 1), j + (ends[0] >> 1 & 1), k + (ends[0] >> 2));
                    p[edge / 4] += (isovalue - v0) / (v1 - v0);
                    p.z = grid_z(volume, p.z);
                    return p;
                };
                for (int t = 0; t < entry.triangle_count; ++t) {
                    TrueTriangle& triangle = all.emplace_back();
                    triangle.name = {surface, i, j, k, t};
                    for (std::size_t n = 0; n < 3; ++n) {
                        const std::uint8_t edge = corners[3 * static_cast<std::size_t>(t) + n];
                        glm::dvec3 p(0);
                        if (edge == gp::center_corner) {
                            for (const std::uint8_t ring : table.ring_of(entry)) {
                                p += on_edge(ring) / static_cast<double>(entry.ring_size);
                            }
                        } else {
                            p = on_edge(edge);
                        }
                        const glm::dvec3 px = view.to_px(p);
                        triangle.p_voxel[n] = p;
                        triangle.p_px[n] = {std::floor(px.x * 16 + 0.5) / 16,
                                            std::floor(px.y * 16 + 0.5) / 16};
                        triangle.z[n] = px.z;
                    }
                    const auto& [a, b, c] = triangle.p_px;
                    triangle.low_px = glm::min(glm::min(a, b), c) - edge_tolerance_px;
                    triangle.high_px = glm::max(glm::max(a, b), c) + edge_tolerance_px;
                }
            }
        }
    }
    return all;
}

/// 64 of 2^24 steps: floats give 30, planes at their ends some more.
inline constexpr double depth_tolerance = 64.0 / (1 << 24);

inline glm::dvec2 center_of(int x, int y) {
    return {x + 0.5, y + 0.5};
}

/// Triangles on a pixel's ray, in drawing order.
struct OnRay {
    std::vector<const TrueTriangle*> sure, possible;  ///< Sure ones are possible, too.
};

inline OnRay on_ray(const std::vector<TrueTriangle>& all, int x, int y) {
    OnRay ray;
    const glm::dvec2 p = center_of(x, y);
    for (const TrueTriangle& t : all) {
        if (!t.box_holds(p)) {  // Quick, and of what has no area the edges bound nothing.
            continue;
        }
        const double margin = t.inside(p);
        if (margin >= -edge_tolerance_px) {
            ray.possible.push_back(&t);
        }
        if (margin >= edge_tolerance_px && std::abs(t.area()) > 0) {
            ray.sure.push_back(&t);
        }
    }
    return ray;
}

/// How far a triangle's depth at the pixel may be from depth_at(), and its own slant over the
/// distance that its edges may have moved.
inline double depth_doubt(const TrueTriangle& t) {
    return depth_tolerance + t.steepness() * 2 * edge_tolerance_px;
}

}  // namespace pxpl5::test
