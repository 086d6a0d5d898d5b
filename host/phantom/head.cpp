// A head as magnetic resonance sees it: bright brain, gray skin, dark bone, water and air.
#include <limits>

#include "host/phantom/catalogue.hpp"
#include "host/phantom/folds.hpp"
#include "host/phantom/head_shapes.hpp"
#include "host/phantom/noise.hpp"

namespace pxpl5::host::phantom {

namespace {

// Signal, without unit.
constexpr float air = 8, flesh = 150, bone = 22, water = 42, gray_matter = 245, white_matter = 345;
constexpr float skull_marrow = 120;
constexpr float scanner_noise = 9;

constexpr float blur_mm = 1.3F;  ///< Half the width over which a voxel mixes tissues.
constexpr float cortex_mm = 4;   ///< Thickness of gray matter.
constexpr float water_mm = 2.5F, skull_mm = 7;  ///< Layers around the brain.
constexpr float skull_marrow_mm = 1.2F;         ///< Half the thickness of the marrow in the skull.
constexpr float marrow_from_z_mm = 50;          ///< Only the top of the skull holds marrow.
constexpr float scalp_mm = 5;                   ///< Least depth of bone below the skin.
constexpr float furrow_mm = 1.9F;               ///< Half the width of a furrow at its mouth.
constexpr float furrow_depth_mm = 15;
constexpr float crown_mm = 5;       ///< Rounding of a fold's crown.
constexpr float fissure_mm = 1.6F;  ///< Half the gap between the hemispheres.
constexpr float folium_mm = 7;      ///< From one leaf of the cerebellum to the next.
constexpr glm::vec3 center_of_scan_mm(0, 1, -4);
constexpr float folds_wavelength_mm = 25;
constexpr std::uint32_t folds_seed = 1993;

float inside_share(float distance_mm) {
    return std::min(std::max(0.5F - distance_mm * (0.5F / blur_mm), 0.0F), 1.0F);
}

float mixed_with(float old_value, float new_value, float share) {
    return old_value + (new_value - old_value) * share;
}

Field skin(const Grid& grid) {
    using namespace head;
    Field field(grid);
    join_both(field, skin_balls);
    join(field, neck);
    join_both(field, eye_sockets, Join::carve);
    join_both(field, eye_lids);
    join_both(field, features);
    join_both(field, creases, Join::carve);
    join(field, ear_shell);
    join_line(field, ear_rim, 3);
    join(field, ear_hollow, Join::carve);
    return field;
}

Field airways(const Grid& grid) {
    Field field(grid);
    for (const Ball& ball : head::airways) join(field, ball);
    join_line(field, head::windpipe, 3);
    return field;
}

Field face_bones(const Grid& grid) {
    Field field(grid);
    join_line(field, head::jaw_bone, 3);
    join_line(field, head::teeth, 3);
    for (const Ball& ball : head::neck_bones) join(field, ball);
    return field;
}

/// Ventricles and eyes.
Field waters(const Grid& grid) {
    Field field(grid);
    join_line(field, head::ventricle, 3);
    join_line(field, head::ventricle_horn, 3);
    for (const Ball& ball : head::middle_ventricles) join(field, ball);
    join(field, head::eye_ball);
    return field;
}

/// Cerebrum without folds.
Field smooth_cerebrum(const Grid& grid) {
    using namespace head;
    Field field(grid);
    join_both(field, cerebrum);
    return field;
}

/// Fissures that everybody has.
Field fissures(const Grid& grid) {
    using namespace head;
    Field field(grid);
    join_line(field, lateral_fissure, 3);
    join_line(field, lateral_fissure_floor, 3);
    join_line(field, central_sulcus, 3);
    return field;
}

/// Cerebellum with its leaves.
Field cerebellum(const Grid& grid) {
    Field field(grid);
    join_both(field, head::cerebellum);
    for (int z = 0; z < grid.nz; ++z) {
        for (int y = 0; y < grid.ny; ++y) {
            const float tilted = grid.z_mm(z) + 0.35F * grid.y_mm(y);
            const float leaf = 1.2F * wave(tilted / folium_mm);
            float* row = field.distance_mm.data() + grid.row(y, z);
            for (int x = 0; x < grid.nx; ++x) row[x] += leaf;
        }
    }
    return field;
}

Field brain_stem(const Grid& grid) {
    Field field(grid);
    join_line(field, head::brain_stem, 5);
    return field;
}

Field core(const Grid& grid) {
    Field field(grid);
    join(field, head::core);
    return field;
}

/// Half fields, each right for x > 0 and, mirrored, for x < 0.
struct Half {
    Field skin_mm, air_mm, bone_mm, water_mm, cerebrum_mm, fissure_mm, hind_brain_mm, stem_mm,
        core_mm;
};

Half half_of(const Grid& grid) {
    return {skin(grid),     airways(grid),    face_bones(grid), waters(grid), smooth_cerebrum(grid),
            fissures(grid), cerebellum(grid), brain_stem(grid), core(grid)};
}

/// Distance to the folded cerebrum, from the smooth one's and the furrow's.
float folded(float smooth_mm, float furrow_distance_mm, float fissure_distance_mm, float x_mm) {
    const float depth = std::max(-smooth_mm, 0.0F);
    const float half_width = furrow_mm * (1 - depth / furrow_depth_mm);
    const float into_furrow = half_width - furrow_distance_mm;
    const float into_fissure = std::max(fissure_mm - std::abs(x_mm), -fissure_distance_mm);
    const float crowned = -smooth_min(-smooth_mm, -into_furrow, crown_mm, 0.25F / crown_mm);
    return -smooth_min(-crowned, -into_fissure, 3, 0.25F / 3);
}

/// Signal at one voxel, from all distances.
float signal(const Half& half, std::size_t h, float furrow_distance_mm, float x_mm, float z_mm) {
    const float hull =
        std::min(std::min(half.cerebrum_mm.distance_mm[h], half.hind_brain_mm.distance_mm[h]),
                 half.stem_mm.distance_mm[h]);
    const float cerebrum_mm = folded(half.cerebrum_mm.distance_mm[h], furrow_distance_mm,
                                     half.fissure_mm.distance_mm[h], x_mm);
    const float hind_mm = std::min(half.hind_brain_mm.distance_mm[h], half.stem_mm.distance_mm[h]);
    const float brain_mm = std::min(std::min(cerebrum_mm, half.core_mm.distance_mm[h]), hind_mm);
    const float matter =
        mixed_with(gray_matter, white_matter, ramp(-brain_mm, cortex_mm - 1, cortex_mm + 1.5F));
    float value = mixed_with(air, flesh, inside_share(half.skin_mm.distance_mm[h]));
    const float under_scalp = half.skin_mm.distance_mm[h] + scalp_mm;
    const float skull = std::max(hull - water_mm - skull_mm, under_scalp);
    value =
        mixed_with(value, bone, inside_share(std::max(half.bone_mm.distance_mm[h], under_scalp)));
    value = mixed_with(value, air, inside_share(half.air_mm.distance_mm[h]));
    value = mixed_with(value, bone, inside_share(skull));
    const float marrow_mm = std::abs(hull - water_mm - 0.5F * skull_mm) - skull_marrow_mm;
    value = mixed_with(
        value, skull_marrow,
        inside_share(std::max(std::max(marrow_mm, under_scalp + 2), marrow_from_z_mm - z_mm)));
    value = mixed_with(value, water, inside_share(hull - water_mm));
    value = mixed_with(value, matter, inside_share(brain_mm));
    return mixed_with(value, water, inside_share(half.water_mm.distance_mm[h]));
}

}  // namespace

PhantomInfo head_info() {
    return {"phantom:head",
            "a head with a folded brain in the manner of magnetic resonance",
            {96, 96, 109},
            Scalar::int16,
            {1.875, 2.25, 2.125},
            {{"skin", 70.5, {228, 182, 152}, 269720}, {"brain", 200.5, {222, 170, 164}, 0}},
            {}};
}

Volume make_head(const PhantomInfo& info) {
    const Grid grid = grid_of(info, center_of_scan_mm);
    const Half half = half_of(left_half(grid));
    const glm::vec3 reach = head::brain_radius + margin_mm;
    const Field furrows = furrow_distance(
        grid, box_around(grid, head::brain_center - reach, head::brain_center + reach),
        {head::brain_center, head::brain_radius, folds_wavelength_mm, folds_seed});
    std::vector<std::int16_t> voxels(grid.voxel_count());
    const int middle = grid.nx / 2;
    for (int z = 0; z < grid.nz; ++z) {
        for (int y = 0; y < grid.ny; ++y) {
            const std::size_t row = grid.row(y, z), half_row = half.skin_mm.grid.row(y, z);
            for (int x = 0; x < grid.nx; ++x) {
                const int from_middle = x < middle ? middle - 1 - x : x - middle;
                const std::size_t h = half_row + static_cast<std::size_t>(from_middle);
                const std::size_t i = row + static_cast<std::size_t>(x);
                const float value =
                    signal(half, h, furrows.distance_mm[i], grid.x_mm(x), grid.z_mm(z)) +
                    scanner_noise * grain(static_cast<std::uint32_t>(i));
                voxels[i] = rounded<std::int16_t>(std::max(value, 0.0F));
            }
        }
    }
    return volume_of(info, grid, voxels);
}

}  // namespace pxpl5::host::phantom
