#include "gp_firmware/render/draw_scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <optional>

#include "gp_firmware/render/sphere_program.hpp"
#include "isa/contract/triangle_shape.hpp"

namespace pxpl5::gp {

namespace {

namespace region = isa::region;

/// Distance from the guard band's border at which the corners of a line's box stay inside the band.
constexpr double guard = guard_px * subpixels - line_width_subpixels;
constexpr double z_first = region::z_margin, z_last = region::z_far - region::z_margin;

/// An end of a line and its distances from all clipping planes. A distance >= 0 is inside.
struct End {
    glm::dvec4 p_grid;  ///< Homogeneous.
    std::array<double, 7 + max_clip_planes> distances{};
};

End end_of(const glm::vec3& p_voxel, const Projection& projection) {
    End end{projection.voxel_to_grid_exact * glm::dvec4(p_voxel, 1.0)};
    const glm::dvec4& p = end.p_grid;
    end.distances = {p.w - static_cast<double>(w_min),
                     p.x + guard * p.w,
                     guard * p.w - p.x,
                     p.y + guard * p.w,
                     guard * p.w - p.y,
                     p.z - z_first * p.w,
                     z_last * p.w - p.z};
    std::size_t k = 7;
    for (const glm::vec4& plane : projection.clip_planes) {
        end.distances[k++] = glm::dot(glm::dvec4(plane), glm::dvec4(p_voxel, 1.0));
    }
    return end;
}

/// A point of a line on the screen's grid, before rounding.
struct Point {
    double x = 0, y = 0, z = 0;
};

Point point_at(const End& from, const End& to, double t) {
    const glm::dvec4 p = from.p_grid + (to.p_grid - from.p_grid) * t;
    return {std::clamp(p.x / p.w, -guard, guard), std::clamp(p.y / p.w, -guard, guard),
            std::clamp(p.z / p.w, z_first, z_last)};
}

/// Returns the part of the line inside all planes. Source: Liang & Barsky 1984.
std::optional<std::array<Point, 2>> visible_part(const Line& line, const Projection& projection) {
    const End from = end_of(line.from_voxel, projection), to = end_of(line.to_voxel, projection);
    double first = 0, last = 1;
    for (std::size_t k = 0; k < 7 + projection.clip_planes.size(); ++k) {
        const double a = from.distances[k], b = to.distances[k];
        if (a < 0 && b < 0) {
            return std::nullopt;
        }
        if (a < 0) {
            first = std::max(first, a / (a - b));
        } else if (b < 0) {
            last = std::min(last, a / (a - b));
        }
    }
    if (first > last) {
        return std::nullopt;
    }
    return std::array{point_at(from, to, first), point_at(from, to, last)};
}

ScreenVertex corner(const Point& p, double dx, double dy) {
    ScreenVertex v;
    v.x = static_cast<std::int32_t>(std::floor(p.x + dx + 0.5));
    v.y = static_cast<std::int32_t>(std::floor(p.y + dy + 0.5));
    v.z = static_cast<std::int32_t>(p.z);
    v.nz = region::normal_unit;
    return v;
}

}  // namespace

DrawCounts draw_spheres(const SlabMesh& mesh, const Projection& projection, const RegionGrid& grid,
                        const SurfaceStyle& style, RegionPrograms& programs) {
    const std::uint32_t surface_word = isa::triangle::surface_word(style.index + 1U);
    DrawCounts counts{static_cast<std::uint32_t>(mesh.spheres.size()), 0};
    for (const Sphere& sphere : mesh.spheres) {
        const std::optional<ScreenSphere> screen = screen_sphere(sphere, projection, grid);
        if (!screen) {
            continue;
        }
        const std::uint32_t emitted_before = counts.triangles_out;
        const PixelBox& box = screen->box;
        for (int row = box.y0 >> region_bits; row <= box.y1 >> region_bits; ++row) {
            for (int column = box.x0 >> region_bits; column <= box.x1 >> region_bits; ++column) {
                const auto words = sphere_program(*screen, column << region_bits,
                                                  row << region_bits, surface_word);
                if (!words) {
                    continue;
                }
                const int number = grid.first_region + row * grid.columns + column;
                std::memcpy(programs.append(static_cast<std::size_t>(number), words->size()),
                            words->data(), sizeof *words);
                ++counts.triangles_out;
            }
        }
        counts.drawn += counts.triangles_out > emitted_before ? 1 : 0;
    }
    return counts;
}

DrawCounts draw_lines(const SlabMesh& mesh, const Projection& projection, const RegionGrid& grid,
                      const SurfaceStyle& style, RegionPrograms& programs) {
    DrawCounts counts{static_cast<std::uint32_t>(mesh.lines.size()), 0};
    const SurfaceStyle both_sides{style.index, false};
    for (const Line& line : mesh.lines) {
        const auto part = visible_part(line, projection);
        if (!part) {
            continue;
        }
        const auto& [from, to] = *part;
        constexpr double half = line_width_subpixels / 2.0;
        const double length = std::hypot(to.x - from.x, to.y - from.y);
        // A line toward the eye is a dot.
        const double ax = length > 0 ? (to.x - from.x) / length * half : half;
        const double ay = length > 0 ? (to.y - from.y) / length * half : 0;
        const ScreenVertex a = corner(from, -ax - ay, -ay + ax),
                           b = corner(from, -ax + ay, -ay - ax), c = corner(to, ax + ay, ay - ax),
                           d = corner(to, ax - ay, ay + ax);
        const std::uint32_t emitted = draw_screen_triangle(a, b, c, grid, both_sides, programs) +
                                      draw_screen_triangle(a, c, d, grid, both_sides, programs);
        counts.triangles_out += emitted;
        counts.drawn += emitted > 0 ? 1 : 0;
    }
    return counts;
}

}  // namespace pxpl5::gp
