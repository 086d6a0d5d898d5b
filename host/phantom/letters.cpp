// A block shaped like an L, with a raised letter on each side: a mirrored or turned picture shows.
#include <limits>

#include "host/phantom/catalogue.hpp"

namespace pxpl5::host::phantom {

namespace {

/// A straight stroke of a letter, in a frame of 4 (right) by 6 (up) units.
struct Stroke {
    float from_right, from_up, to_right, to_up;
};

constexpr Stroke letter_l[] = {{0, 6, 0, 0}, {0, 0, 4, 0}};
constexpr Stroke letter_r[] = {{0, 0, 0, 6}, {0, 6, 3, 6}, {3, 6, 4, 5.2F}, {4, 5.2F, 4, 4},
                               {4, 4, 3, 3}, {3, 3, 0, 3}, {2, 3, 4, 0}};
constexpr Stroke letter_a[] = {{0, 0, 2, 6}, {2, 6, 4, 0}, {0.8F, 2.2F, 3.2F, 2.2F}};
constexpr Stroke letter_p[] = {{0, 0, 0, 6},    {0, 6, 3, 6}, {3, 6, 4, 5.2F},
                               {4, 5.2F, 4, 4}, {4, 4, 3, 3}, {3, 3, 0, 3}};
constexpr Stroke letter_s[] = {{4, 5.2F, 3, 6}, {3, 6, 1, 6}, {1, 6, 0, 5.2F}, {0, 5.2F, 0, 4},
                               {0, 4, 1, 3},    {1, 3, 3, 3}, {3, 3, 4, 2},    {4, 2, 4, 0.8F},
                               {4, 0.8F, 3, 0}, {3, 0, 1, 0}, {1, 0, 0, 0.8F}};
constexpr Stroke letter_i[] = {{1, 6, 3, 6}, {2, 6, 2, 0}, {1, 0, 3, 0}};

/// A letter, seen by a reader who faces that side of the patient.
struct Letter {
    std::span<const Stroke> strokes;
    glm::vec3 middle_mm;  ///< On the block's face.
    glm::vec3 right, up;  ///< The reader's, in patient axes.
    float unit_mm;
};

// The block: a stem on the patient's right, a foot towards the left (half sizes in mm).
constexpr glm::vec3 stem_middle(-22, 0, 0), stem_half(22, 20, 46);
constexpr glm::vec3 foot_middle(0, 0, -24), foot_half(44, 20, 22);

constexpr float stroke_radius_mm = 2.75F, foot_blend_mm = 1.5F;
constexpr float density_per_mm = 100, surface_density = 500;

// Looking along d with `up` upwards, the right hand is d x up. Superior and inferior have the
// patient's front upwards.
const Letter letters[] = {
    {letter_a, {-22, -20, 16}, {1, 0, 0}, {0, 0, 1}, 6},
    {letter_p, {-22, 20, 16}, {-1, 0, 0}, {0, 0, 1}, 6},
    {letter_r, {-44, 0, 4}, {0, -1, 0}, {0, 0, 1}, 6},
    {letter_l, {44, 0, -24}, {0, 1, 0}, {0, 0, 1}, 5},
    {letter_s, {-22, 0, 46}, {-1, 0, 0}, {0, -1, 0}, 4},
    {letter_i, {0, 0, -46}, {1, 0, 0}, {0, -1, 0}, 4},
};

/// Distance to a box, rounded by nothing.
void join_block(Field& field, glm::vec3 middle, glm::vec3 half) {
    const glm::vec3 reach = half + margin_mm;
    join(field, box_around(field.grid, middle - reach, middle + reach), Join::unite, 0,
         [=](float x, float y, float z) {
             const float dx = std::abs(x - middle.x) - half.x, dy = std::abs(y - middle.y) - half.y,
                         dz = std::abs(z - middle.z) - half.z;
             const float ox = std::max(dx, 0.0F), oy = std::max(dy, 0.0F), oz = std::max(dz, 0.0F);
             return std::sqrt(ox * ox + oy * oy + oz * oz) +
                    std::min(std::max(dx, std::max(dy, dz)), 0.0F);
         });
}

void join_letter(Field& field, const Letter& letter) {
    const auto point = [&](float right, float up) {
        return letter.middle_mm +
               letter.unit_mm * ((right - 2) * letter.right + (up - 3) * letter.up);
    };
    for (const Stroke& s : letter.strokes) {
        join(field, Rod{point(s.from_right, s.from_up), stroke_radius_mm,
                        point(s.to_right, s.to_up), stroke_radius_mm});
    }
}

}  // namespace

PhantomInfo letters_info() {
    return {"phantom:letters",
            "an L-shaped block with raised L R A P S I on the patient's sides",
            {84, 48, 72},
            Scalar::int16,
            {1.25, 1.25, 1.5},
            {{"surface", surface_density + 0.5, {230, 200, 90}, 0}},
            {}};
}

Volume make_letters(const PhantomInfo& info) {
    Field block(grid_of(info));
    join_block(block, stem_middle, stem_half);
    join_block(block, foot_middle, foot_half);
    Field ink(block.grid);
    for (const Letter& letter : letters) join_letter(ink, letter);
    // Rounded where they meet the block, sharp among themselves, where rounding would be a knot.
    for (std::size_t i = 0; i < block.distance_mm.size(); ++i) {
        block.distance_mm[i] = smooth_min(block.distance_mm[i], ink.distance_mm[i], foot_blend_mm,
                                          0.25F / foot_blend_mm);
    }
    std::vector<std::int16_t> voxels;
    voxels.reserve(block.distance_mm.size());
    for (const float d : block.distance_mm) {
        const float density = surface_density - density_per_mm * d;
        voxels.push_back(rounded<std::int16_t>(std::min(std::max(density, 0.0F), 1000.0F)));
    }
    return volume_of(info, block.grid, voxels);
}

}  // namespace pxpl5::host::phantom
