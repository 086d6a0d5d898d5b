#include "host/phantom/field.hpp"

#include <cassert>

#include "host/phantom/noise.hpp"
#include "host/phantom/shape_distance.hpp"

namespace pxpl5::host::phantom {

namespace {

/// Distance to a thick triangle: its three edges as rods, and the plate between them.
struct PlateDistance {
    RodDistance ab, bc, ca;
    glm::vec3 a, normal, to_b, to_c;  ///< Duals: to_b . (p - a) is the weight of corner b.
    float a_radius, b_growth, c_growth;

    PlateDistance(const Corner& p, const Corner& q, const Corner& r)
        : ab({p.p_mm, p.radius_mm, q.p_mm, q.radius_mm}),
          bc({q.p_mm, q.radius_mm, r.p_mm, r.radius_mm}),
          ca({r.p_mm, r.radius_mm, p.p_mm, p.radius_mm}),
          a(p.p_mm),
          a_radius(p.radius_mm),
          b_growth(q.radius_mm - p.radius_mm),
          c_growth(r.radius_mm - p.radius_mm) {
        const glm::vec3 u = q.p_mm - p.p_mm, v = r.p_mm - p.p_mm;
        const float uu = u.x * u.x + u.y * u.y + u.z * u.z, vv = v.x * v.x + v.y * v.y + v.z * v.z,
                    uv = u.x * v.x + u.y * v.y + u.z * v.z, area = uu * vv - uv * uv;
        assert(area > 0);
        to_b = (u * vv - v * uv) / area;
        to_c = (v * uu - u * uv) / area;
        const glm::vec3 cross(u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x);
        normal = cross / std::sqrt(area);
    }

    float operator()(float x, float y, float z) const {
        const float px = x - a.x, py = y - a.y, pz = z - a.z;
        const float wb = px * to_b.x + py * to_b.y + pz * to_b.z;
        const float wc = px * to_c.x + py * to_c.y + pz * to_c.z;
        const float height = std::abs(px * normal.x + py * normal.y + pz * normal.z);
        const float within = std::min(std::min(wb, wc), 1 - wb - wc);
        const float plate = height - (a_radius + wb * b_growth + wc * c_growth);
        const float edges = std::min(std::min(ab(x, y, z), bc(x, y, z)), ca(x, y, z));
        return within >= 0 ? std::min(plate, edges) : edges;
    }
};

Ball mirrored(Ball ball) {
    ball.center_mm.x = -ball.center_mm.x;
    ball.tilt_deg.y = -ball.tilt_deg.y;
    ball.tilt_deg.z = -ball.tilt_deg.z;
    return ball;
}

Rod mirrored(Rod rod) {
    rod.a_mm.x = -rod.a_mm.x;
    rod.b_mm.x = -rod.b_mm.x;
    return rod;
}

int first_at_or_after(float p_mm, float first_mm, float spacing_mm, int count) {
    const int i = static_cast<int>(std::floor((p_mm - first_mm) / spacing_mm));
    return std::clamp(i, 0, count);
}

Box box_around(const Grid& grid, const Rod& rod) {
    const glm::vec3 reach(std::max(rod.a_radius_mm, rod.b_radius_mm) + rod.blend_mm + margin_mm);
    return box_around(grid, glm::min(rod.a_mm, rod.b_mm) - reach,
                      glm::max(rod.a_mm, rod.b_mm) + reach);
}

template <class Shape>
void join_each_and_its_mirror_image(Field& field, std::span<const Shape> shapes, Join how) {
    for (const Shape& shape : shapes) {
        join(field, shape, how);
        join(field, mirrored(shape), how);
    }
}

/// Averages (1 2 1) along an axis of `count` values that lie `step` apart. The first and last value
/// stand for what is beyond them, which at the middle of a left half is the mirror image.
void average_along(std::vector<float>& values, std::vector<float>& old, int count, int step) {
    old = values;
    const auto block = static_cast<std::size_t>(count) * static_cast<std::size_t>(step);
    for (std::size_t first = 0; first < values.size(); first += block) {
        for (int k = 0; k < count; ++k) {
            const auto at = [&](int i) {
                return old.data() + first +
                       static_cast<std::size_t>(std::clamp(i, 0, count - 1) * step);
            };
            const float *before = at(k - 1), *here = at(k), *after = at(k + 1);
            float* out = values.data() + (here - old.data());
            for (int i = 0; i < step; ++i) {
                out[i] = 0.25F * (before[i] + after[i]) + 0.5F * here[i];
            }
        }
    }
}

}  // namespace

Grid centered_grid(int nx, int ny, int nz, glm::vec3 spacing_mm, glm::vec3 center_mm) {
    const glm::vec3 last(static_cast<float>(nx - 1), static_cast<float>(ny - 1),
                         static_cast<float>(nz - 1));
    return {nx, ny, nz, spacing_mm, center_mm - 0.5F * (last * spacing_mm)};
}

Grid left_half(const Grid& grid) {
    assert(grid.nx % 2 == 0);
    Grid half = grid;
    half.nx = grid.nx / 2;
    half.first_mm.x = grid.x_mm(half.nx);
    return half;
}

Box box_around(const Grid& g, glm::vec3 low_mm, glm::vec3 high_mm) {
    return {first_at_or_after(low_mm.x, g.first_mm.x, g.spacing_mm.x, g.nx),
            first_at_or_after(high_mm.x + g.spacing_mm.x, g.first_mm.x, g.spacing_mm.x, g.nx),
            first_at_or_after(low_mm.y, g.first_mm.y, g.spacing_mm.y, g.ny),
            first_at_or_after(high_mm.y + g.spacing_mm.y, g.first_mm.y, g.spacing_mm.y, g.ny),
            first_at_or_after(low_mm.z, g.first_mm.z, g.spacing_mm.z, g.nz),
            first_at_or_after(high_mm.z + g.spacing_mm.z, g.first_mm.z, g.spacing_mm.z, g.nz)};
}

Box box_around(const Grid& grid, const Ball& ball) {
    const glm::mat3 m = turned(ball.tilt_deg);
    const glm::vec3 r = ball.radius_mm;
    glm::vec3 half(ball.blend_mm + margin_mm);
    // Half the width of a turned ellipsoid along each axis of the patient.
    for (int i = 0; i < 3; ++i) {
        const float u = m[0][i] * r.x, v = m[1][i] * r.y, w = m[2][i] * r.z;
        half[i] += std::sqrt(u * u + v * v + w * w);
    }
    return box_around(grid, ball.center_mm - half, ball.center_mm + half);
}

Box box_around(const Grid& grid, const Strand& strand) {
    const auto& [a, b, c] = strand;
    const glm::vec3 reach(std::max({a.radius_mm, b.radius_mm, c.radius_mm}) + margin_mm +
                          strand_blend_mm / 4);
    return box_around(grid, glm::min(glm::min(a.p_mm, b.p_mm), c.p_mm) - reach,
                      glm::max(glm::max(a.p_mm, b.p_mm), c.p_mm) + reach);
}

glm::mat3 turned(glm::vec3 tilt_deg) {
    const auto s = [](float deg) { return static_cast<float>(sine(deg / 360.0)); };
    const auto c = [](float deg) { return static_cast<float>(sine(deg / 360.0 + 0.25)); };
    const float sx = s(tilt_deg.x), cx = c(tilt_deg.x), sy = s(tilt_deg.y), cy = c(tilt_deg.y),
                sz = s(tilt_deg.z), cz = c(tilt_deg.z);
    const glm::mat3 about_x(1, 0, 0, 0, cx, sx, 0, -sx, cx);
    const glm::mat3 about_y(cy, 0, -sy, 0, 1, 0, sy, 0, cy);
    const glm::mat3 about_z(cz, sz, 0, -sz, cz, 0, 0, 0, 1);
    return about_z * about_y * about_x;
}

void join(Field& field, const Ball& ball, Join how) {
    join(field, box_around(field.grid, ball), how, ball.blend_mm, BallDistance(ball));
}

void join(Field& field, const Rod& rod, Join how) {
    join(field, box_around(field.grid, rod), how, rod.blend_mm, RodDistance(rod));
}

void add(Bellies& bellies, const Ball& ball) {
    add(bellies, box_around(bellies.first.grid, ball), BallDistance(ball));
}

void add(Bellies& bellies, const Rod& rod) {
    add(bellies, box_around(bellies.first.grid, rod), RodDistance(rod));
}

void add(Bellies& bellies, const Strand& strand) {
    add(bellies, box_around(bellies.first.grid, strand), StrandDistance(strand));
}

Field parted(const Bellies& bellies, float gap_mm) {
    Field field = bellies.first;
    for (std::size_t i = 0; i < field.distance_mm.size(); ++i) {
        const float first = field.distance_mm[i], second = bellies.second.distance_mm[i];
        field.distance_mm[i] = std::max(first, 0.5F * (gap_mm - (second - first)));
    }
    return field;
}

void join(Field& field, std::span<const Corner> corners, const Plate& plate, float blend_mm) {
    const auto corner = [&](int i) { return corners[static_cast<std::size_t>(i)]; };
    const Corner a = corner(plate.a), b = corner(plate.b), c = corner(plate.c);
    const glm::vec3 reach(std::max({a.radius_mm, b.radius_mm, c.radius_mm}) + blend_mm + margin_mm);
    join(field,
         box_around(field.grid, glm::min(glm::min(a.p_mm, b.p_mm), c.p_mm) - reach,
                    glm::max(glm::max(a.p_mm, b.p_mm), c.p_mm) + reach),
         Join::unite, blend_mm, PlateDistance(a, b, c));
}

void join_line(Field& field, std::span<const Corner> line, float blend_mm, Join how) {
    for (std::size_t i = 1; i < line.size(); ++i) {
        const Corner &a = line[i - 1], &b = line[i];
        join(field, Rod{a.p_mm, a.radius_mm, b.p_mm, b.radius_mm, blend_mm}, how);
    }
}

void join_both(Field& field, std::span<const Ball> balls, Join how) {
    join_each_and_its_mirror_image(field, balls, how);
}

void join_both(Field& field, std::span<const Rod> rods, Join how) {
    join_each_and_its_mirror_image(field, rods, how);
}

void smooth(Field& field, int passes) {
    for (float& d : field.distance_mm) d = std::min(std::max(d, -margin_mm), margin_mm);
    std::vector<float> old;
    const Grid& g = field.grid;
    for (int pass = 0; pass < passes; ++pass) {
        average_along(field.distance_mm, old, g.nx, 1);
        average_along(field.distance_mm, old, g.ny, g.nx);
        average_along(field.distance_mm, old, g.nz, g.nx * g.ny);
    }
}

void nearer(Field& field, const Field& other) {
    assert(field.distance_mm.size() == other.distance_mm.size());
    for (std::size_t i = 0; i < field.distance_mm.size(); ++i) {
        field.distance_mm[i] = std::min(field.distance_mm[i], other.distance_mm[i]);
    }
}

}  // namespace pxpl5::host::phantom
