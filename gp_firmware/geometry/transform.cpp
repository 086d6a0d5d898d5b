#include "gp_firmware/geometry/transform.hpp"

#include <fmt/format.h>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <stdexcept>

#include "isa/depth.hpp"

namespace pxpl5::gp {

namespace {

namespace region = isa::region;

constexpr float guard = static_cast<float>(guard_px * subpixels);
constexpr float z_first = static_cast<float>(region::z_margin);
constexpr float z_last = static_cast<float>(region::z_far - region::z_margin);
constexpr double rigid_tolerance = 1e-3;

/// Clip space to grid: the viewport, y turned down, depth within its margins.
glm::dmat4 viewport(const Camera& camera) {
    const double half_width = 0.5 * subpixels * camera.width_px;
    const double half_height = 0.5 * subpixels * camera.height_px;
    const double half_depth = 0.5 * isa::depth_span;
    glm::dmat4 m(0.0);
    m[0][0] = half_width;
    m[1][1] = -half_height;
    m[2][2] = half_depth;
    m[3] = glm::dvec4(half_width, half_height, half_depth + region::z_margin, 1);
    return m;
}

void check_finite(const glm::dmat4& m, const char* name) {
    for (int column = 0; column < 4; ++column) {
        for (int row = 0; row < 4; ++row) {
            // What overflows a float is of no use to transform() either.
            if (!std::isfinite(static_cast<float>(m[column][row]))) {
                throw std::invalid_argument(fmt::format("{}[{}][{}] is {}, not a finite float",
                                                        name, column, row, m[column][row]));
            }
        }
    }
}

void check(const Camera& camera) {
    const int width = camera.width_px, height = camera.height_px;
    if (width < 1 || width > max_picture_px || height < 1 || height > max_picture_px) {
        throw std::invalid_argument(fmt::format("the picture is {} x {} pixels; each must be 1..{}",
                                                width, height, max_picture_px));
    }
    if (camera.clip_planes.size() > max_clip_planes) {
        throw std::invalid_argument(
            fmt::format("{} clip planes; {} at most", camera.clip_planes.size(), max_clip_planes));
    }
    check_finite(camera.voxel_to_eye, "voxel_to_eye");
    check_finite(camera.projection, "projection");
    check_finite(camera.voxel_to_patient, "voxel_to_patient");
    for (const glm::dvec4& p : camera.clip_planes) {
        if (!std::isfinite(static_cast<float>(p.x)) || !std::isfinite(static_cast<float>(p.y)) ||
            !std::isfinite(static_cast<float>(p.z)) || !std::isfinite(static_cast<float>(p.w))) {
            throw std::invalid_argument(
                fmt::format("clip plane ({}, {}, {}, {}) is not finite", p.x, p.y, p.z, p.w));
        }
    }
}

/// Patient to eye axes: a rotation, perhaps with a reflection.
glm::dmat3 rotation(const Camera& camera) {
    const glm::dmat3 to_patient(camera.voxel_to_patient);
    if (glm::determinant(to_patient) == 0) {
        throw std::invalid_argument("voxel_to_patient has determinant 0");
    }
    const glm::dmat3 m = glm::dmat3(camera.voxel_to_eye) * glm::inverse(to_patient);
    const glm::dmat3 gram = glm::transpose(m) * m;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            const double wanted = i == j ? 1 : 0;
            if (!(std::abs(gram[i][j] - wanted) < rigid_tolerance)) {
                throw std::invalid_argument(fmt::format(
                    "voxel_to_eye is no rigid motion of patient space: axes {} and {} have product "
                    "{}, not {}",
                    i, j, gram[i][j], wanted));
            }
        }
    }
    return m;
}

Float4 to_lanes(glm::dvec4 v) {
    return Float4{static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z),
                  static_cast<float>(v.w)};
}

/// All bits that are set in any lane.
std::uint32_t any_lane(Int4 bits) {
    const auto halves = std::bit_cast<std::array<std::uint64_t, 2>>(bits);
    const std::uint64_t half = halves[0] | halves[1];
    return static_cast<std::uint32_t>(half) | static_cast<std::uint32_t>(half >> 32);
}

/// Lane by lane; what is not a number becomes `low`.
Float4 clamp(Float4 v, Float4 low, Float4 high) {
    v = v > low ? v : low;
    return v < high ? v : high;
}

/// Position and outside bits, all but the user's planes.
void place(const Projection& m, const Vertex& vertex, ScreenVertex& out) {
    constexpr Float4 low{-guard, -guard, z_first, 0}, high{guard, guard, z_last, 2};
    constexpr Int4 below{outside_left, outside_top, outside_near, 0};
    constexpr Int4 above{outside_right, outside_bottom, outside_far, 0};
    // Conversion to integers cuts; x and y are rounded, and made positive first.
    constexpr Float4 bias{guard + 0.5F, guard + 0.5F, 0, 0};

    const Float4 h = ((m.voxel_to_grid[0] * all_lanes(vertex.p_voxel.x) +
                       m.voxel_to_grid[1] * all_lanes(vertex.p_voxel.y)) +
                      m.voxel_to_grid[2] * all_lanes(vertex.p_voxel.z)) +
                     m.voxel_to_grid[3];
    const float w = h[3];
    const Float4 p = h / all_lanes(w);
    out.outside = w >= w_min ? any_lane((~(p >= low) & below) | (~(p <= high) & above))
                             : std::uint32_t{outside_w};
    const Int4 q = __builtin_convertvector(clamp(p, low, high) + bias, Int4);
    out.x = q[0] - guard_px * subpixels;
    out.y = q[1] - guard_px * subpixels;
    out.z = q[2];
}

/// The normal, rounded to integers.
void turn(const Projection& m, const Vertex& vertex, ScreenVertex& out) {
    constexpr float unit = region::normal_unit, shift = 2 * unit;
    const Float4 n = (m.normal_to_eye[0] * all_lanes(static_cast<float>(vertex.normal[0])) +
                      m.normal_to_eye[1] * all_lanes(static_cast<float>(vertex.normal[1]))) +
                     m.normal_to_eye[2] * all_lanes(static_cast<float>(vertex.normal[2]));
    const Float4 held =
        clamp(n, Float4{-unit, -unit, -unit, -unit}, Float4{unit, unit, unit, unit});
    constexpr Float4 bias{shift + 0.5F, shift + 0.5F, shift + 0.5F, shift + 0.5F};
    const Int4 q = __builtin_convertvector(held + bias, Int4);
    out.nx = q[1] - static_cast<std::int32_t>(shift);
    out.ny = q[2] - static_cast<std::int32_t>(shift);
    out.nz = q[3] - static_cast<std::int32_t>(shift);
}

}  // namespace

Projection prepare(const Camera& camera) {
    check(camera);
    Projection result;
    result.voxel_to_grid_exact = viewport(camera) * camera.projection * camera.voxel_to_eye;
    check_finite(result.voxel_to_grid_exact, "voxel to screen");
    const glm::dmat3 turn_to_eye = rotation(camera);
    result.patient_to_eye = turn_to_eye;
    for (int column = 0; column < 4; ++column) {
        result.voxel_to_grid[static_cast<std::size_t>(column)] =
            to_lanes(result.voxel_to_grid_exact[column]);
    }
    const double scale = region::normal_unit / static_cast<double>(normal_one);
    for (int column = 0; column < 3; ++column) {
        const glm::dvec3 axis = turn_to_eye[column] * scale;
        result.normal_to_eye[static_cast<std::size_t>(column)] =
            to_lanes({0, axis.x, axis.y, axis.z});
    }
    for (const glm::dvec4& plane : camera.clip_planes) {
        result.clip_planes.emplace_back(plane);
    }
    return result;
}

void transform(std::span<const Vertex> vertices, const Projection& projection,
               std::span<ScreenVertex> out) {
    assert(out.size() == vertices.size());
    const Projection m = projection;  // A copy: `out` cannot change it, so it stays in registers.
    for (std::size_t i = 0; i < vertices.size(); ++i) {
        place(m, vertices[i], out[i]);
        turn(m, vertices[i], out[i]);
    }
    std::uint32_t bit = outside_user;
    for (const glm::vec4& plane : projection.clip_planes) {
        for (std::size_t i = 0; i < vertices.size(); ++i) {
            const glm::vec3& p = vertices[i].p_voxel;
            const float distance = ((plane.x * p.x + plane.y * p.y) + plane.z * p.z) + plane.w;
            out[i].outside |= distance >= 0 ? 0 : bit;
        }
        bit <<= 1;
    }
}

}  // namespace pxpl5::gp
