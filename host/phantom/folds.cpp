#include "host/phantom/folds.hpp"

#include <array>

#include "host/phantom/noise.hpp"

namespace pxpl5::host::phantom {

namespace {

constexpr std::size_t wave_count = 24;
constexpr float two_pi = 6.2831853F;
constexpr float least_reach =
    0.05F;  ///< Share of the ellipsoid's radius; the pattern ends at its center.

/// One plane wave: turns per mm, and turns at the origin.
struct PlaneWave {
    float x, y, z, phase;
};

/// Waves of one length in all directions.
std::array<PlaneWave, wave_count> waves_of(const FoldPattern& pattern) {
    std::array<PlaneWave, wave_count> waves{};
    std::uint32_t key = pattern.seed;
    for (PlaneWave& w : waves) {
        float square = 0;
        // A point of the unit ball, pushed to its surface, points anywhere with equal chance.
        do {
            w.x = 2 * even(key++) - 1;
            w.y = 2 * even(key++) - 1;
            w.z = 2 * even(key++) - 1;
            square = w.x * w.x + w.y * w.y + w.z * w.z;
        } while (square > 1 || square < 0.01F);
        const float scale = 1 / (std::sqrt(square) * pattern.wavelength_mm);
        w.x *= scale;
        w.y *= scale;
        w.z *= scale;
        w.phase = even(key++);
    }
    return waves;
}

/// A run of points on the ellipsoid.
struct Run {
    std::vector<float> x, y, z, sum;

    explicit Run(std::size_t count) : x(count), y(count), z(count), sum(count) {}
};

void project_row(Run& run, const Grid& grid, const Box& box, int y, int z,
                 const FoldPattern& pattern) {
    const glm::vec3 inverse = 1.0F / pattern.radius_mm;
    const float py = grid.y_mm(y) - pattern.center_mm.y, pz = grid.z_mm(z) - pattern.center_mm.z;
    const float off_row = py * inverse.y * py * inverse.y + pz * inverse.z * pz * inverse.z;
    for (int i = 0; i < box.x1 - box.x0; ++i) {
        const float px = grid.x_mm(box.x0 + i) - pattern.center_mm.x;
        const float reach = std::sqrt(px * inverse.x * px * inverse.x + off_row);
        const float scale = 1 / std::max(reach, least_reach);
        const auto k = static_cast<std::size_t>(i);
        run.x[k] = px * scale;
        run.y[k] = py * scale;
        run.z[k] = pz * scale;
        run.sum[k] = 0;
    }
}

/// Adds a wave, weighted by how much it runs along the surface: where it runs into the depth, its
/// trace on the surface would be longer than the others'.
void add_wave(Run& run, const PlaneWave& w, float turns_to_sine) {
    for (std::size_t i = 0; i < run.sum.size(); ++i) {
        const float turns = w.x * run.x[i] + w.y * run.y[i] + w.z * run.z[i];
        const float into_depth = turns * turns_to_sine;
        const float weight = std::max(1 - into_depth * into_depth, 0.0F);
        run.sum[i] += weight * wave(turns + w.phase);
    }
}

}  // namespace

Field furrow_distance(const Grid& grid, const Box& box, const FoldPattern& pattern) {
    Field field(grid);
    const std::array<PlaneWave, wave_count> waves = waves_of(pattern);
    Run run(static_cast<std::size_t>(box.x1 - box.x0));
    const float radius = (pattern.radius_mm.x + pattern.radius_mm.y + pattern.radius_mm.z) / 3;
    const float turns_to_sine = pattern.wavelength_mm / radius;
    // A sum of n waves has deviation sqrt(n / 2) and slope 2 pi / wavelength times that; the
    // squares of the weights are 8 / 15 in the mean.
    const float to_mm = pattern.wavelength_mm /
                        (two_pi * std::sqrt(0.5F * (8.0F / 15) * static_cast<float>(wave_count)));
    for (int z = box.z0; z < box.z1; ++z) {
        for (int y = box.y0; y < box.y1; ++y) {
            project_row(run, grid, box, y, z, pattern);
            for (const PlaneWave& w : waves) add_wave(run, w, turns_to_sine);
            float* row = field.distance_mm.data() + grid.row(y, z) + box.x0;
            for (std::size_t i = 0; i < run.sum.size(); ++i) row[i] = std::abs(run.sum[i]) * to_mm;
        }
    }
    return field;
}

}  // namespace pxpl5::host::phantom
