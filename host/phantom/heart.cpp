// A beating left ventricle, whose volume at each time has a formula, and a right one beside it.
#include "host/phantom/catalogue.hpp"

namespace pxpl5::host::phantom {

namespace {

constexpr int frames = 30;
constexpr double beat_ms = 900;

// Half axes of the left ventricle's cavity, relaxed and at the end of the contraction: 110.0 and
// 43.6 ml, so that 60 % of the blood are ejected.
constexpr double long_mm = 42, short_mm = 25, least_long_mm = 36, least_short_mm = 17;
constexpr double wall_mm = 9;  ///< At the tip always, at the sides while relaxed.
// Half axes of the right ventricle's cavity along the heart's axes, and how much they shrink.
constexpr glm::dvec3 right_mm{40, 26, 30}, right_shrink_mm{4, 5, 3};
constexpr glm::dvec3 right_center_mm{-4, 30, 0};
constexpr double right_wall_mm = 4;

// The heart's axes: to the tip, which points to the left, front and feet; to the right ventricle;
// and across both.
constexpr glm::dvec3 to_tip{0.6, -0.48, -0.64}, to_right{-0.8, -0.36, -0.48}, across{0, 0.8, -0.6};
constexpr glm::dvec3 center_mm{8.3, -0.7, 3.45};  ///< The left ventricle's.

// Hounsfield units, as of a CT whose contrast medium has reached the left side.
constexpr double fat_hu = -90, muscle_hu = 105, right_blood_hu = 190, blood_hu = 380;
constexpr double edge_mm = 6;  ///< Width of a change from one tissue to another.

/// 0 at or below `low`, 1 at or above `high`, smooth between.
double smooth_step(double value, double low, double high) {
    const double t = std::min(std::max((value - low) / (high - low), 0.0), 1.0);
    return t * t * (3 - 2 * t);
}

/// How far the heart is contracted, 0 to 1, at a share of the beat.
double contraction(double share) {
    return smooth_step(share, 0, 0.35) - smooth_step(share, 0.45, 0.9);
}

/// Distance to an ellipsoid in mm, negative inside: right near its surface.
double distance_mm(glm::dvec3 p, glm::dvec3 half_axes) {
    const glm::dvec3 a = p / half_axes, b = a / half_axes;
    const double inside = std::sqrt(a.x * a.x + a.y * a.y + a.z * a.z);
    const double slope = std::sqrt(b.x * b.x + b.y * b.y + b.z * b.z);
    return slope > 0 ? inside * (inside - 1) / slope : -half_axes.y;
}

/// Half axes of the heart's parts, along its axes, at one time.
struct Shapes {
    glm::dvec3 cavity, wall, right, right_wall;
};

/// The wall keeps its volume, and so becomes thicker.
Shapes shapes_at(double share) {
    const double s = contraction(share);
    const double length = long_mm - s * (long_mm - least_long_mm);
    const double width = short_mm - s * (short_mm - least_short_mm);
    const double muscle = (short_mm + wall_mm) * (short_mm + wall_mm) * (long_mm + wall_mm) -
                          short_mm * short_mm * long_mm;
    const double outer = std::sqrt((muscle + width * width * length) / (length + wall_mm));
    const glm::dvec3 right = right_mm - s * right_shrink_mm;
    return {{length, width, width},
            {length + wall_mm, outer, outer},
            right,
            right + glm::dvec3(right_wall_mm)};
}

/// Share of a tissue inside an edge.
double inside(double distance) {
    return std::min(std::max(0.5 - distance / edge_mm, 0.0), 1.0);
}

double value_at(glm::dvec3 p, const Shapes& shapes) {
    const double cavity = distance_mm(p, shapes.cavity), wall = distance_mm(p, shapes.wall);
    const glm::dvec3 q = p - right_center_mm;
    const double right = std::max(distance_mm(q, shapes.right), -wall);
    const double outer = std::min(wall, distance_mm(q, shapes.right_wall));
    return fat_hu + (muscle_hu - fat_hu) * inside(outer) +
           (right_blood_hu - muscle_hu) * inside(right) + (blood_hu - muscle_hu) * inside(cavity);
}

}  // namespace

PhantomInfo heart_info() {
    return {"phantom:heart",
            "a beating heart of ellipsoids, with contrast medium in the left ventricle",
            {128, 128, 64},
            Scalar::int16,
            {1.125, 1.125, 2.25},
            {{"blood", 242.5, {200, 60, 56}, 0}, {"heart", 7.5, {214, 150, 130}, 0}},
            {{"long half axis, relaxed", long_mm},
             {"short half axis, relaxed", short_mm},
             {"long half axis, contracted", least_long_mm},
             {"short half axis, contracted", least_short_mm}},
            frames,
            beat_ms / frames};
}

Volume make_heart(const PhantomInfo& info, int frame) {
    const Grid grid = grid_of(info);
    const Shapes shapes = shapes_at(static_cast<double>(frame - 1) / frames);
    std::vector<std::int16_t> voxels;
    voxels.reserve(grid.voxel_count());
    for (int z = 0; z < grid.nz; ++z) {
        for (int y = 0; y < grid.ny; ++y) {
            for (int x = 0; x < grid.nx; ++x) {
                const glm::dvec3 p =
                    glm::dvec3(static_cast<double>(grid.x_mm(x)), static_cast<double>(grid.y_mm(y)),
                               static_cast<double>(grid.z_mm(z))) -
                    center_mm;
                const auto along = [&](glm::dvec3 axis) {
                    return p.x * axis.x + p.y * axis.y + p.z * axis.z;
                };
                const double hu = value_at({along(to_tip), along(to_right), along(across)}, shapes);
                voxels.push_back(static_cast<std::int16_t>(std::floor(hu + 0.5)));
            }
        }
    }
    Volume volume = volume_of(info, grid, voxels);
    take_frame(info, frame, volume);
    return volume;
}

}  // namespace pxpl5::host::phantom
