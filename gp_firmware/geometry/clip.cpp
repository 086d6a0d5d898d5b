#include "gp_firmware/geometry/clip.hpp"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>

namespace pxpl5::gp {

namespace {

namespace region = isa::region;

constexpr double guard = guard_px * subpixels;
constexpr double z_first = region::z_margin;
constexpr double z_last = region::z_far - region::z_margin;

struct Corner {
    glm::dvec4 p_grid;  ///< Homogeneous.
    glm::dvec3 p_voxel;
    glm::dvec3 normal;  ///< Eye axes, normal_unit.
    std::uint32_t outside = 0;
    const ScreenVertex* own = nullptr;  ///< The vertex of the mesh; null for a new corner.
};

/// A polygon of at most max_polygon_corners, on the stack.
struct Polygon {
    std::array<Corner, max_polygon_corners> corners;
    std::size_t count = 0;

    void add(const Corner& corner) {
        assert(count < corners.size());
        corners[count++] = corner;
    }
};

/// Returns the signed distance from the plane of Outside bit `bit`, in the plane's own measure. It
/// is >= 0 inside.
double distance(const Corner& corner, std::uint32_t bit, const Projection& projection) {
    const glm::dvec4& p = corner.p_grid;
    switch (bit) {
        case outside_left:
            return p.x + guard * p.w;
        case outside_right:
            return guard * p.w - p.x;
        case outside_top:
            return p.y + guard * p.w;
        case outside_bottom:
            return guard * p.w - p.y;
        case outside_near:
            return p.z - z_first * p.w;
        case outside_far:
            return z_last * p.w - p.z;
        case outside_w:
            return p.w - static_cast<double>(w_min);
        default:
            break;
    }
    assert(bit >= outside_user);
    const auto index = static_cast<std::size_t>(std::countr_zero(bit / outside_user));
    const glm::dvec4 plane(projection.clip_planes.at(index));
    const glm::dvec3& v = corner.p_voxel;
    return ((plane.x * v.x + plane.y * v.y) + plane.z * v.z) + plane.w;
}

/// Returns the point where the edge crosses the plane. The computation runs from the inside corner
/// to the outside corner in both triangles of the edge, so that both get the same point.
Corner crossing(const Corner& inside, const Corner& outside, std::uint32_t bit,
                std::uint32_t planes_ahead, const Projection& projection) {
    const double d_in = distance(inside, bit, projection);
    const double d_out = distance(outside, bit, projection);
    // The outside bits come from floats; these distances may disagree by their rounding.
    const double quotient = d_in / (d_in - d_out);
    const double t = quotient > 0 ? std::min(quotient, 1.0) : 0.0;
    Corner corner;
    corner.p_grid = inside.p_grid + (outside.p_grid - inside.p_grid) * t;
    corner.p_voxel = inside.p_voxel + (outside.p_voxel - inside.p_voxel) * t;
    corner.normal = inside.normal + (outside.normal - inside.normal) * t;
    for (std::uint32_t rest = planes_ahead; rest != 0; rest &= rest - 1) {
        const std::uint32_t next = rest & (~rest + 1);
        if (!(distance(corner, next, projection) >= 0)) {
            corner.outside |= next;
        }
    }
    return corner;
}

Polygon clip_at(const Polygon& in, std::uint32_t bit, std::uint32_t planes_ahead,
                const Projection& projection) {
    Polygon out;
    for (std::size_t i = 0; i < in.count; ++i) {
        const Corner& corner = in.corners[i];
        const Corner& next = in.corners[i + 1 == in.count ? 0 : i + 1];
        const bool is_in = (corner.outside & bit) == 0, next_is_in = (next.outside & bit) == 0;
        if (is_in) {
            out.add(corner);
        }
        if (is_in != next_is_in) {
            out.add(crossing(is_in ? corner : next, is_in ? next : corner, bit, planes_ahead,
                             projection));
        }
    }
    return out;
}

Corner corner_of(const Vertex& vertex, const ScreenVertex& screen, const Projection& projection) {
    Corner corner;
    corner.p_voxel = glm::dvec3(vertex.p_voxel);
    corner.p_grid = projection.voxel_to_grid_exact * glm::dvec4(corner.p_voxel, 1.0);
    corner.normal = glm::dvec3(0);
    for (std::size_t k = 0; k < 3; ++k) {
        const std::array<float, 3>& column = projection.normal_to_eye[k];
        corner.normal +=
            glm::dvec3(column[0], column[1], column[2]) * static_cast<double>(vertex.normal[k]);
    }
    corner.outside = screen.outside;
    corner.own = &screen;
    return corner;
}

std::int32_t to_grid(double value, double low, double high) {
    // Maps NaN to `low`.
    return static_cast<std::int32_t>(std::floor(value > low ? std::min(value, high) : low));
}

ScreenVertex to_screen(const Corner& corner) {
    const glm::dvec4& p = corner.p_grid;
    constexpr double unit = region::normal_unit;
    ScreenVertex v;
    v.x = to_grid(p.x / p.w + 0.5, -guard, guard);
    v.y = to_grid(p.y / p.w + 0.5, -guard, guard);
    v.z = to_grid(p.z / p.w, z_first, z_last);
    v.nx = to_grid(corner.normal.x + 0.5, -unit, unit);
    v.ny = to_grid(corner.normal.y + 0.5, -unit, unit);
    v.nz = to_grid(corner.normal.z + 0.5, -unit, unit);
    return v;
}

}  // namespace

void clip_triangle(const std::array<const Vertex*, 3>& corners,
                   const std::array<const ScreenVertex*, 3>& screen, const Projection& projection,
                   std::vector<ScreenVertex>& polygon) {
    polygon.clear();
    Polygon current;
    for (std::size_t k = 0; k < 3; ++k) {
        current.add(corner_of(*corners[k], *screen[k], projection));
    }
    // The eye's plane comes first, because a corner behind it has no other bits yet. New corners
    // may lie outside of any plane that follows, so they are tested against all of them.
    const auto user_count = static_cast<std::uint32_t>(projection.clip_planes.size());
    std::uint32_t ahead = outside_left | outside_right | outside_top | outside_bottom |
                          outside_near | outside_far | (((1U << user_count) - 1) * outside_user);
    current = clip_at(current, outside_w, ahead, projection);
    while (ahead != 0 && current.count >= 3) {
        const std::uint32_t bit = ahead & (~ahead + 1);
        ahead &= ahead - 1;
        const auto end = current.corners.begin() + static_cast<std::ptrdiff_t>(current.count);
        if (std::any_of(current.corners.begin(), end,
                        [bit](const Corner& c) { return (c.outside & bit) != 0; })) {
            current = clip_at(current, bit, ahead, projection);
        }
    }
    for (std::size_t i = 0; current.count >= 3 && i < current.count; ++i) {
        const Corner& corner = current.corners[i];
        polygon.push_back(corner.own != nullptr ? *corner.own : to_screen(corner));
    }
}

}  // namespace pxpl5::gp
