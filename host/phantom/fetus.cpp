// A fetal face as volume ultrasound sees it, at rest and in motion: echoes of 0 to 255.
#include <algorithm>
#include <array>
#include <limits>

#include "host/phantom/catalogue.hpp"
#include "host/phantom/fetus_shapes.hpp"
#include "host/phantom/noise.hpp"

namespace pxpl5::host::phantom {

namespace {

// Echoes.
constexpr float fluid_echo = 9, skin_echo = 150, flesh_echo = 105, shadow_echo = 82;
constexpr float skin_mm = 1.2F;   ///< Half the blur of the skin's echo.
constexpr float flesh_mm = 2.5F;  ///< Depth at which the skin's echo is over.
constexpr float shadow_begin_mm = 6, shadow_end_mm = 14;  ///< Bone keeps the sound out below.
constexpr float speckle_share = 0.13F;                    ///< Deviation, of the echo.
constexpr glm::vec3 center_of_scan_mm(0, 3, -1);

/// The probe's fan: half widths at its front, and how much they grow per mm of depth.
struct Fan {
    float front_mm, half_x_mm, grow_x, half_z_mm, grow_z;
};
constexpr Fan fan{-26, 27, 0.36F, 33, 0.24F};

// Motion: the hand sinks below the cheek, and the mouth opens.
constexpr int waving_frames = 16;
constexpr double waving_ms = 125;  ///< 4D ultrasound has 8 volumes per second.
constexpr glm::vec3 sink_mm(-1, -1, -11);
constexpr float open_mm = 2;  ///< Added to the radius of the crease between the lips.
constexpr std::uint32_t other_speckle = 0x9E37'79B9U;

/// How far hand and mouth are from rest, 0 to 1.
float motion_at(int frame) {
    const float share = static_cast<float>(frame - 1) / waving_frames;
    return ramp(share, 0, 0.5F) - ramp(share, 0.5F, 1);
}

Rod moved(Rod rod, glm::vec3 by_mm) {
    rod.a_mm += by_mm;
    rod.b_mm += by_mm;
    return rod;
}

template <std::size_t N>
void join_all(Field& field, const Rod (&rods)[N], glm::vec3 by_mm) {
    for (const Rod& rod : rods) join(field, moved(rod, by_mm));
}

Field fetus_surface(const Grid& grid, float motion) {
    using namespace fetus;
    Field field(grid);
    join_both(field, head_balls);
    for (const Ball& ball : trunk_balls) join(field, ball);
    join_both(field, eye_sockets, Join::carve);
    join_both(field, eye_lids);
    join_both(field, features);
    std::array<Rod, std::size(creases)> furrows;
    std::ranges::copy(creases, furrows.begin());
    furrows[0].a_radius_mm += open_mm * motion;
    join_both(field, furrows, Join::carve);
    join_both(field, std::span(&ear_shell, 1));
    for (std::size_t i = 1; i < std::size(ear_rim); ++i) {
        const Corner &a = ear_rim[i - 1], &b = ear_rim[i];
        const Rod rim{a.p_mm, a.radius_mm, b.p_mm, b.radius_mm, 1.5F};
        join_both(field, std::span(&rim, 1));
    }
    return field;
}

Field hand(const Grid& grid, float motion) {
    const glm::vec3 by_mm = motion * sink_mm;
    Field field(grid);
    join_all(field, fetus::arm, by_mm);
    Ball palm = fetus::palm;
    palm.center_mm += by_mm;
    join(field, palm);
    join_all(field, fetus::fingers, by_mm);
    return field;
}

/// Echo at a depth below the nearest surface, without speckle.
float echo(float distance_mm) {
    const float below = ramp(-distance_mm, -skin_mm, skin_mm);
    const float flesh = ramp(-distance_mm, skin_mm, flesh_mm + skin_mm);
    const float shadow = ramp(-distance_mm, shadow_begin_mm, shadow_end_mm);
    const float tissue = skin_echo + (flesh_echo - skin_echo) * flesh;
    return fluid_echo + (tissue + (shadow_echo - tissue) * shadow - fluid_echo) * below;
}

/// 1 well inside the fan, 0 outside.
float in_fan(float x, float y, float z) {
    const float depth = y - fan.front_mm;
    const float side_x = fan.half_x_mm + fan.grow_x * depth - std::abs(x);
    const float side_z = fan.half_z_mm + fan.grow_z * depth - std::abs(z - center_of_scan_mm.z);
    return ramp(std::min(std::min(side_x, side_z), depth), 0, 1.5F);
}

/// Speckle: grains a little longer across the beam than along it. Deviation 1.
float speckle(std::uint32_t key, std::uint32_t row, std::uint32_t slice) {
    return (grain(key) + grain(key + 1) + grain(key + row) + grain(key + slice)) * 0.5F;
}

/// motion   From rest, 0 to 1.
/// grains   Added to the number of each grain of speckle.
Volume fetus_volume(const PhantomInfo& info, float motion, std::uint32_t grains) {
    const Grid grid = grid_of(info, center_of_scan_mm);
    Field surface = fetus_surface(grid, motion);
    nearer(surface, hand(grid, motion));
    std::vector<std::uint8_t> voxels(grid.voxel_count());
    const auto row_step = static_cast<std::uint32_t>(grid.nx);
    const std::uint32_t slice_step = row_step * static_cast<std::uint32_t>(grid.ny);
    for (int z = 0; z < grid.nz; ++z) {
        for (int y = 0; y < grid.ny; ++y) {
            const std::size_t row = grid.row(y, z);
            for (int x = 0; x < grid.nx; ++x) {
                const std::size_t i = row + static_cast<std::size_t>(x);
                const std::uint32_t key = static_cast<std::uint32_t>(i) + grains;
                const float lit = in_fan(grid.x_mm(x), grid.y_mm(y), grid.z_mm(z));
                const float noise = 1 + speckle_share * speckle(key, row_step, slice_step);
                voxels[i] = rounded<std::uint8_t>(echo(surface.distance_mm[i]) * noise * lit);
            }
        }
    }
    return volume_of(info, grid, voxels);
}

}  // namespace

PhantomInfo fetus_info() {
    return {"phantom:fetus",
            "a fetal face and hand in the manner of volume ultrasound",
            {128, 64, 96},
            Scalar::uint8,
            {0.65625, 0.875, 0.8125},
            {{"face", 50.5, {226, 170, 122}, 70874}},
            {}};
}

Volume make_fetus(const PhantomInfo& info) {
    return fetus_volume(info, 0, 0);
}

PhantomInfo waving_fetus_info() {
    PhantomInfo info = fetus_info();
    info.name = "phantom:waving-fetus";
    info.description = "a fetus that moves its hand and mouth, in the manner of 4D ultrasound";
    info.surfaces[0].paper_triangles = 0;
    info.frames = waving_frames;
    info.frame_ms = waving_ms;
    return info;
}

Volume make_waving_fetus(const PhantomInfo& info, int frame) {
    Volume volume =
        fetus_volume(info, motion_at(frame), static_cast<std::uint32_t>(frame - 1) * other_speckle);
    take_frame(info, frame, volume);
    return volume;
}

}  // namespace pxpl5::host::phantom
