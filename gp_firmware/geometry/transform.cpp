#include "gp_firmware/geometry/transform.hpp"

#include <fmt/format.h>
#include <cmath>
#include <cstddef>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <stdexcept>

#include "isa/contract/depth.hpp"

namespace pxpl5::gp {

namespace {

namespace region = isa::region;

constexpr double rigid_tolerance = 1e-3;

/// Returns the matrix from clip space to the grid, with y pointing down and depth within its
/// margins.
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
            // transform() computes in floats, so a value beyond their range is refused.
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

/// Returns the matrix from patient to eye axes: a rotation, perhaps with a reflection.
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

}  // namespace

Projection prepare(const Camera& camera) {
    check(camera);
    Projection result;
    result.voxel_to_grid_exact = viewport(camera) * camera.projection * camera.voxel_to_eye;
    check_finite(result.voxel_to_grid_exact, "voxel to screen");
    const glm::dmat3 turn_to_eye = rotation(camera);
    result.patient_to_eye = turn_to_eye;
    for (int column = 0; column < 4; ++column) {
        for (int row = 0; row < 4; ++row) {
            result.voxel_to_grid[static_cast<std::size_t>(column)][static_cast<std::size_t>(row)] =
                static_cast<float>(result.voxel_to_grid_exact[column][row]);
        }
    }
    const double scale = region::normal_unit / static_cast<double>(normal_one);
    for (int column = 0; column < 3; ++column) {
        const glm::dvec3 axis = turn_to_eye[column] * scale;
        result.normal_to_eye[static_cast<std::size_t>(column)] = {
            static_cast<float>(axis.x), static_cast<float>(axis.y), static_cast<float>(axis.z)};
    }
    for (const glm::dvec4& plane : camera.clip_planes) {
        result.clip_planes.emplace_back(plane);
    }
    return result;
}

Projection with_gray_values(Projection projection) {
    constexpr float scale = region::normal_unit / normal_one;
    projection.normal_to_eye = {{{scale, 0, 0}, {0, scale, 0}, {0, 0, scale}}};
    projection.patient_to_eye = glm::dmat3(1.0);
    return projection;
}

std::vector<ScreenVertex> transformed(std::span<const Vertex> vertices,
                                      const Projection& projection) {
    std::vector<GridVertex> grid(vertices.size());
    std::vector<std::uint32_t> outside(vertices.size());
    transform(vertices, projection, grid, outside);
    std::vector<ScreenVertex> screen;
    screen.reserve(vertices.size());
    for (std::size_t i = 0; i < vertices.size(); ++i) {
        screen.push_back(screen_vertex(grid[i], outside[i]));
    }
    return screen;
}

}  // namespace pxpl5::gp
