// A pelvis as computed tomography sees it, in Hounsfield units.
#include <limits>

#include "host/phantom/catalogue.hpp"
#include "host/phantom/noise.hpp"
#include "host/phantom/pelvis_shapes.hpp"
#include "host/phantom/shape_distance.hpp"

namespace pxpl5::host::phantom {

namespace {

// Hounsfield units.
constexpr float air = -1000, fat = -105, muscle = 55, bowel_wall = 35;
constexpr float cortex = 950, sponge = 420, marrow = 20;
constexpr float scanner_noise = 4;

// A surface is smooth if the values near it are linear in distance for as far as its cells and
// their gradients reach: two voxels, or 8 mm, where there is room.
constexpr float skin_surface = -300.5F, skin_per_mm = 26;  ///< Value at the skin, and its slope.
constexpr float bone_surface = 250.5F, bone_per_mm = 50;
constexpr float bone_reach_mm = 4.5F;                                ///< Outwards.
constexpr float cortex_begin_mm = 4, cortex_mm = 7, sponge_mm = 10;  ///< Depths.
constexpr float tissue_blur_mm = 4.5F;   ///< Half the width over which other tissues mix.
constexpr float fat_under_skin_mm = 12;  ///< Least thickness.
constexpr float fat_plane_mm = 4;        ///< Between two muscles.
constexpr glm::vec3 center_of_scan_mm(0, 12, 26);

/// How much of a voxel at this distance is inside, 0 to 1.
float inside_share(float distance_mm) {
    return std::min(std::max(0.5F - distance_mm * (0.5F / tissue_blur_mm), 0.0F), 1.0F);
}

float mixed_with(float old_value, float new_value, float share) {
    return old_value + (new_value - old_value) * share;
}

template <std::size_t N, std::size_t M>
void join_plates(Field& field, const Corner (&corners)[N], const Plate (&plates)[M], float blend) {
    for (const Plate& plate : plates) join(field, corners, plate, blend);
}

/// Hip bone with its socket, without the femur.
Field hip_bone(const Grid& grid) {
    using namespace pelvis;
    Field field(grid);
    join(field, Ball{hip_center_mm, glm::vec3(cup_radius_mm)});
    // The socket opens sideways, forwards and downwards.
    const glm::vec3 opening(0.76F, -0.36F, -0.54F);
    join(field, Ball{hip_center_mm + 66.0F * opening, glm::vec3(56)}, Join::carve);
    join_plates(field, hip_corners, hip_plates, 1.5F);
    smooth(field, 1);
    join_both(field, hip_rods);
    join(field, Ball{hip_center_mm, glm::vec3(socket_radius_mm)}, Join::carve);
    join(field, Ball{hip_center_mm + 22.0F * opening, glm::vec3(socket_radius_mm)}, Join::carve);
    join(field, symphysis, Join::carve);
    return field;
}

Field femur(const Grid& grid) {
    Field field(grid);
    join(field, Ball{pelvis::hip_center_mm, glm::vec3(pelvis::femur_head_radius_mm)});
    for (const Rod& rod : pelvis::femur_rods) join(field, rod);
    return field;
}

Field spine(const Grid& grid) {
    using namespace pelvis;
    Field field(grid);
    for (const Ball& ball : sacrum_bodies) join(field, ball);
    join_plates(field, sacrum_corners, sacrum_plates, 2);
    smooth(field, 1);
    join_both(field, sacrum_laminae);
    join_line(field, sacrum_crest, 4);
    join_both(field, sacrum_holes, Join::carve);
    join_line(field, sacrum_canal, 2, Join::carve);
    Field vertebrae(grid);
    join(vertebrae, lumbar_body);
    join_both(vertebrae, lumbar_arches);
    join(vertebrae, lumbar_spine);
    nearer(field, vertebrae);
    return field;
}

Field skin(const Grid& grid) {
    using namespace pelvis;
    Field field(grid);
    join_both(field, body_balls);
    join_both(field, body_rods);
    join_both(field, body_hollows, Join::carve);
    join(field, navel, Join::carve);
    return field;
}

/// The wall of the belly: a shell that ends at the ligament of the groin, the iliac crest and the
/// back. The straight muscle and the flat ones at its side are two bellies.
void add_belly_wall(Bellies& bellies) {
    using namespace pelvis;
    const BallDistance middle(belly_wall);
    const glm::vec3 along = groin_outer_mm - groin_inner_mm;
    const float length = std::sqrt(along.x * along.x + along.z * along.z);
    const float down_x = along.z / length, down_z = -along.x / length;
    const auto wall = [=](float x, float y, float z) {
        const float crest = groin_outer_mm.z + crest_rise * (y - groin_outer_mm.y) - z;
        const float below =
            std::max(down_x * (x - groin_outer_mm.x) + down_z * (z - groin_outer_mm.z),
                     std::min(crest, y - groin_outer_mm.y));
        const float shell = std::abs(middle(x, y, z)) - belly_wall_half_mm;
        return smooth_max(shell, std::max(below, y - wall_back_mm), wall_edge_mm);
    };
    const auto rectus_edge = [](float x, float z) {
        const float below = std::max(rectus_narrows_from_mm - z, 0.0F);
        return x - (rectus_half_width_mm - rectus_narrowing * below);
    };
    const Box box = box_around(bellies.first.grid, belly_wall);
    add(bellies, box, [=](float x, float y, float z) {
        const float tendon = std::max(1 - std::abs(z - tendon_height_mm) / tendon_half_mm, 0.0F);
        const float side = std::max(rectus_edge(x, z), white_line_half_mm - x);
        return smooth_max(wall(x, y, z) + tendon_depth_mm * tendon, std::max(side, y),
                          wall_edge_mm);
    });
    add(bellies, box, [=](float x, float y, float z) {
        const float side = y < 0 ? -rectus_edge(x, z) : -rectus_half_width_mm;
        return smooth_max(wall(x, y, z), side, wall_edge_mm);
    });
}

void add_gluteus_maximus(Bellies& bellies) {
    using namespace pelvis;
    const StrandDistance a(gluteus_maximus[0]), b(gluteus_maximus[1]), c(gluteus_maximus[2]);
    const Grid& grid = bellies.first.grid;
    const Box first = box_around(grid, gluteus_maximus[0]);
    const Box last = box_around(grid, gluteus_maximus[2]);
    const Box box{0, grid.nx, std::min(first.y0, last.y0), grid.ny, last.z0, first.z1};
    add(bellies, box, [=](float x, float y, float z) {
        const float quarter = 0.25F / bundle_blend_mm;
        const float ab = smooth_min(a(x, y, z), b(x, y, z), bundle_blend_mm, quarter);
        return smooth_min(ab, c(x, y, z), bundle_blend_mm, quarter);
    });
}

/// Muscles under a layer of fat, parted by thin planes of fat.
Field muscles(const Grid& grid, const Field& skin_mm) {
    using namespace pelvis;
    Bellies bellies(grid);
    for (const Ball& ball : muscle_balls) add(bellies, ball);
    for (const Rod& rod : muscle_rods) add(bellies, rod);
    for (const Strand& strand : muscle_strands) add(bellies, strand);
    add_gluteus_maximus(bellies);
    add_belly_wall(bellies);
    Field field = parted(bellies, fat_plane_mm);
    for (const Rod& rod : cartilage) join(field, rod);
    join(field, Ball{hip_center_mm, glm::vec3(socket_radius_mm + 2)});
    for (std::size_t i = 0; i < field.distance_mm.size(); ++i) {
        field.distance_mm[i] =
            std::max(field.distance_mm[i], skin_mm.distance_mm[i] + fat_under_skin_mm);
    }
    return field;
}

/// Bowel, bladder and womb: on the whole grid, for they are not symmetric.
Field organs(const Grid& grid) {
    using namespace pelvis;
    Field field(grid);
    join_line(field, rectum, 3);
    join_line(field, blind_gut, 1);
    for (const Ball& ball : bowel_bulk) join(field, ball);
    join(field, womb);
    join(field, bladder);
    return field;
}

Field gas_bubbles(const Grid& grid) {
    Field field(grid);
    for (const Ball& ball : pelvis::gas) join(field, ball);
    return field;
}

/// The half fields, each right for x > 0 and, mirrored, for x < 0.
struct Half {
    Field skin_mm, muscle_mm, bone_mm, marrow_mm;
};

Half half_of(const Grid& grid) {
    const Field skin_mm = skin(grid);
    Half half{skin_mm, muscles(grid, skin_mm), hip_bone(grid), Field(grid)};
    nearer(half.bone_mm, femur(grid));
    nearer(half.bone_mm, spine(grid));
    join(half.marrow_mm, pelvis::femur_marrow);
    return half;
}

float skin_value(float distance_mm) {
    return std::min(std::max(skin_surface - skin_per_mm * distance_mm, air), fat);
}

/// Bone: linear about its surface, then dense, then spongy.
float bone_value(float distance_mm, float marrow_mm, float texture) {
    const float depth = -distance_mm, at_cortex = bone_surface + bone_per_mm * cortex_begin_mm;
    const float rise =
        std::min(std::max((depth - cortex_begin_mm) / (cortex_mm - cortex_begin_mm), 0.0F), 1.0F);
    // Further out the distance is no longer right, and nothing of bone may be left.
    const float gone = (air - cortex) * std::max(-depth - bone_reach_mm, 0.0F);
    const float shell = bone_surface + bone_per_mm * std::min(depth, cortex_begin_mm) + gone;
    const float dense = shell + (cortex - at_cortex) * rise;
    const float spongy = mixed_with(sponge + 40 * texture, marrow, inside_share(marrow_mm));
    return mixed_with(dense, spongy, ramp(depth, cortex_mm, sponge_mm));
}

}  // namespace

PhantomInfo pelvis_info() {
    return {"phantom:pelvis",
            "a pelvis in the manner of computed tomography, in Hounsfield units",
            {128, 128, 56},
            Scalar::int16,
            {3.875, 3.125, 4.0},
            {{"bone", 250.5, {236, 226, 202}, 49552},
             {"skin", -300.5, {224, 172, 140}, 41708},
             {"muscle", -20.5, {178, 70, 60}, 110450}},
            {{"femur head radius", pelvis::femur_head_radius_mm}}};
}

Volume make_pelvis(const PhantomInfo& info) {
    const Grid grid = grid_of(info, center_of_scan_mm);
    const Half half = half_of(left_half(grid));
    const Field organ = organs(grid), gas = gas_bubbles(grid);
    std::vector<std::int16_t> voxels(grid.voxel_count());
    const int middle = grid.nx / 2;
    for (int z = 0; z < grid.nz; ++z) {
        for (int y = 0; y < grid.ny; ++y) {
            const std::size_t row = grid.row(y, z), half_row = half.skin_mm.grid.row(y, z);
            for (int x = 0; x < grid.nx; ++x) {
                const int from_middle = x < middle ? middle - 1 - x : x - middle;
                const std::size_t h = half_row + static_cast<std::size_t>(from_middle);
                const std::size_t i = row + static_cast<std::size_t>(x);
                const auto key = static_cast<std::uint32_t>(i);
                float value = skin_value(half.skin_mm.distance_mm[h]);
                value = mixed_with(value, bowel_wall, inside_share(organ.distance_mm[i]));
                value = mixed_with(value, air, inside_share(gas.distance_mm[i]));
                value = mixed_with(value, muscle, inside_share(half.muscle_mm.distance_mm[h]));
                // The greater, not a mixture: bone's surface must not depend on what is around it.
                value = std::max(
                    value, bone_value(half.bone_mm.distance_mm[h], half.marrow_mm.distance_mm[h],
                                      grain(key ^ 0x5bd1e995U)));
                voxels[i] = rounded<std::int16_t>(value + scanner_noise * grain(key));
            }
        }
    }
    return volume_of(info, grid, voxels);
}

}  // namespace pxpl5::host::phantom
