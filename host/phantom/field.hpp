// Distance fields on a voxel grid, and the shapes that are joined into them.
//
// Only + - * / and square roots are used, which IEEE 754 fixes to the bit, so that a phantom is the
// same on every machine. Loops run along x without branches, so that compilers can vectorize them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace pxpl5::host::phantom {

/// Where voxels lie.
struct Grid {
    int nx = 0, ny = 0, nz = 0;  ///< Voxels.
    glm::vec3 spacing_mm{1};
    glm::vec3 first_mm{0};  ///< Center of voxel (0, 0, 0).

    std::size_t voxel_count() const {
        return static_cast<std::size_t>(nx) * static_cast<std::size_t>(ny) *
               static_cast<std::size_t>(nz);
    }
    std::size_t row(int y, int z) const {
        return (static_cast<std::size_t>(z) * static_cast<std::size_t>(ny) +
                static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(nx);
    }
    float x_mm(int x) const { return first_mm.x + spacing_mm.x * static_cast<float>(x); }
    float y_mm(int y) const { return first_mm.y + spacing_mm.y * static_cast<float>(y); }
    float z_mm(int z) const { return first_mm.z + spacing_mm.z * static_cast<float>(z); }
};

/// A grid centered on `center_mm`.
Grid centered_grid(int nx, int ny, int nz, glm::vec3 spacing_mm,
                   glm::vec3 center_mm = glm::vec3(0));

/// The half of a grid with x > 0, if the grid is centered on x = 0 and nx is even.
Grid left_half(const Grid& grid);

inline constexpr float far_mm = 1000;  ///< Distance where no shape is near.
inline constexpr float margin_mm = 8;  ///< How far outside a shape its distance is still right.

/// Distance to the nearest surface in mm, negative inside; right near surfaces, rough elsewhere.
struct Field {
    Grid grid;
    std::vector<float> distance_mm;

    explicit Field(const Grid& g) : grid(g), distance_mm(g.voxel_count(), far_mm) {}
};

/// An ellipsoid; `tilt_deg` turns it about x, then y, then z. `blend_mm` rounds where it joins.
struct Ball {
    glm::vec3 center_mm, radius_mm;
    glm::vec3 tilt_deg{0};
    float blend_mm = 0;
};

/// A line with a radius at each end.
struct Rod {
    glm::vec3 a_mm;
    float a_radius_mm;
    glm::vec3 b_mm;
    float b_radius_mm;
    float blend_mm = 0;
};

/// A corner of a plate of bone, with half the plate's thickness there.
struct Corner {
    glm::vec3 p_mm;
    float radius_mm;
};

/// A muscle that bends at its belly.
struct Strand {
    Corner from, belly, to;
};
inline constexpr float strand_blend_mm = 24;  ///< Rounds a strand's bend.

/// A thick triangle between three corners, by index.
struct Plate {
    int a, b, c;
};

/// The effect of a shape on a field.
enum class Join { unite, carve };

/// Voxels that a shape may change, half open.
struct Box {
    int x0, x1, y0, y1, z0, z1;
};

Box box_around(const Grid& grid, glm::vec3 low_mm, glm::vec3 high_mm);
Box box_around(const Grid& grid, const Ball& ball);
Box box_around(const Grid& grid, const Strand& strand);

/// The lesser of two distances, rounded over `blend_mm`.
inline float smooth_min(float a, float b, float blend_mm, float quarter_blend) {
    const float h = std::max(blend_mm - std::abs(a - b), 0.0F);
    return std::min(a, b) - h * h * quarter_blend;
}

/// The greater of two distances, rounded over `blend_mm` > 0.
inline float smooth_max(float a, float b, float blend_mm) {
    return -smooth_min(-a, -b, blend_mm, 0.25F / blend_mm);
}

/// Joins a shape with the field.
///
/// box          Voxels to visit.
/// blend_mm     Width of the rounding between old and new, >= 0.
/// distance_mm  Callable (x, y, z) in mm -> mm.
template <class Distance>
void join(Field& field, const Box& box, Join how, float blend_mm, const Distance& distance_mm) {
    const float quarter = blend_mm > 0 ? 0.25F / blend_mm : 0.0F;
    const float sign = how == Join::unite ? 1.0F : -1.0F;
    for (int z = box.z0; z < box.z1; ++z) {
        for (int y = box.y0; y < box.y1; ++y) {
            float* row = field.distance_mm.data() + field.grid.row(y, z);
            const float py = field.grid.y_mm(y), pz = field.grid.z_mm(z);
            for (int x = box.x0; x < box.x1; ++x) {
                const float d = distance_mm(field.grid.x_mm(x), py, pz);
                row[x] = sign * smooth_min(sign * row[x], d, blend_mm, quarter);
            }
        }
    }
}

void join(Field& field, const Ball& ball, Join how = Join::unite);
void join(Field& field, const Rod& rod, Join how = Join::unite);
void join(Field& field, std::span<const Corner> corners, const Plate& plate, float blend_mm);

/// A rod through every two neighbors of a line of corners.
void join_line(Field& field, std::span<const Corner> line, float blend_mm, Join how = Join::unite);

/// Shapes of one kind, each also mirrored in x = 0.
void join_both(Field& field, std::span<const Ball> balls, Join how = Join::unite);
void join_both(Field& field, std::span<const Rod> rods, Join how = Join::unite);

/// The nearer of two fields on one grid, without rounding.
void nearer(Field& field, const Field& other);

/// Two fields on one grid: the nearest and the second nearest of many shapes.
struct Bellies {
    Field first, second;

    explicit Bellies(const Grid& grid) : first(grid), second(grid) {}
};

/// Adds a shape that stays apart from the others.
void add(Bellies& bellies, const Ball& ball);
void add(Bellies& bellies, const Rod& rod);
void add(Bellies& bellies, const Strand& strand);

/// Adds any shape: sorts its distance into the two nearest. Arguments as in join().
template <class Distance>
void add(Bellies& bellies, const Box& box, const Distance& distance_mm) {
    const Grid& grid = bellies.first.grid;
    for (int z = box.z0; z < box.z1; ++z) {
        for (int y = box.y0; y < box.y1; ++y) {
            float* first = bellies.first.distance_mm.data() + grid.row(y, z);
            float* second = bellies.second.distance_mm.data() + grid.row(y, z);
            const float py = grid.y_mm(y), pz = grid.z_mm(z);
            for (int x = box.x0; x < box.x1; ++x) {
                const float d = distance_mm(grid.x_mm(x), py, pz);
                second[x] = std::min(second[x], std::max(first[x], d));
                first[x] = std::min(first[x], d);
            }
        }
    }
}

/// One field of all shapes, with a gap of `gap_mm` where two overlap.
Field parted(const Bellies& bellies, float gap_mm);

/// Rounds creases: clamps distances to the margin and averages each with its neighbors (1 2 1),
/// `passes` times along each axis.
void smooth(Field& field, int passes);

/// Rotation matrix of Ball::tilt_deg.
glm::mat3 turned(glm::vec3 tilt_deg);

}  // namespace pxpl5::host::phantom
