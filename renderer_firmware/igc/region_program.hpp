// Generates the programs at the beginning and end of a region: clearing, and deferred Phong
// shading.
//
// The assembly texts and the register map are in renderer_firmware/programs/. The build assembles
// them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "generated/vocabulary.hpp"
#include "ringbus/rules/pass.hpp"

namespace pxpl5::renderer {

/// Directional light in eye space: x right, y up, z toward the viewer.
struct Light {
    struct Direction {
        float x = 0, y = 0, z = 1;
    };
    Direction direction;  ///< Toward the light; any length except 0.
    float intensity = 1;
};

struct Rgb {
    std::uint8_t r = 0, g = 0, b = 0;
};

/// The stipple mask of a surface: how many pixels of each 4 x 4 group show the surface, and which.
struct Screen {
    std::uint32_t opacity = full_opacity;  ///< 1 .. full_opacity.
    /// Surfaces with the same pattern cover the same pixels. Any two of the patterns 0, 1 and 2
    /// leave evenly distributed pixels uncovered. The patterns repeat from 12 on.
    std::uint32_t pattern = 0;
};

/// The lighting of a frame. The color of a pixel is
///   surface * light + 255 * specular * sum I max(0, n.h)^power, limited to 255,
///   light = ambient + sum I max(0, n.l) + 2 rim (1 - n.z)^2,
/// with n turned to the viewer and h = normalize(l + (0, 0, 1)). Lights that could overexpose the
/// surface are bent first (tone_curve.hpp). With a rim, light is cut where it would.
struct Shading {
    std::vector<Light> lights;  ///< 0..4.
    float ambient = 0.2F;
    float specular = 0.3F;              ///< 0..1.
    std::uint32_t specular_power = 20;  ///< 1..128.
    Rgb background;
    std::vector<Rgb>
        surfaces;  ///< Colors. Surface field s of a pixel selects surfaces[s - 1]; 0..255.
    std::vector<Screen> screens;  ///< One per surface; missing ones are opaque.
    std::vector<float> rims;      ///< One per surface, 0..1; missing ones are 0.
    /// The last of `surfaces` are slice planes: their pixels have gray values and no light. A
    /// normal (0, 0, gray) has twice the gray value of 0..255 in field units, or one more.
    std::size_t planes = 0;
    Pass pass{};  ///< Screens move by a pixel per pass. In 16 passes each pixel has every rank.
};

/// Clears a region: every pixel background, far, no normal. Throws like end_of_region().
std::vector<std::uint32_t> prologue(const Shading& shading);

/// Shades the covered pixels of a region and reads all pixels out. A pass instead adds its colors
/// to the sums of the earlier passes in the backing store; the last pass reads out the mean, which
/// is each channel's sum divided by the number of passes, halves rounded up. Requires prologue() of
/// the same shading. Normals are at most 512 field units long (isa::region::normal_unit is unit
/// length); a normal of length 0 gets only ambient light. Overwrites normals and z. Throws
/// std::invalid_argument that names the value and its limit.
std::vector<std::uint32_t> end_of_region(const Shading& shading);

/// Returns the same program for another region of the Renderer. Each region has its own blocks.
/// end_of_region  The program of a pass for slot 0.
/// slot           Less than isa::max_summed_regions(samples).
std::vector<std::uint32_t> at_slot(std::vector<std::uint32_t> end_of_region, std::uint32_t samples,
                                   std::size_t slot);

/// The programs before and after the segments of a transparent surface. They require prologue() of
/// the same shading.
struct DoorPrograms {
    std::uint32_t surface = 0;  ///< Index of the surface.
    std::vector<std::uint32_t> shut, open;
};

/// Returns the programs of all surfaces that are not opaque, ascending. Throws like
/// end_of_region().
std::vector<DoorPrograms> doors(const Shading& shading);

/// Reads out the surface field (bits 0..7) and the depth (8..31). Runs before end_of_region().
std::vector<std::uint32_t> depths();

struct RegionPrograms {
    std::vector<std::uint32_t> prologue, end_of_region;
    std::vector<DoorPrograms> doors;
    std::vector<std::uint32_t> depths;  ///< Empty unless requested.
};

/// Returns all programs; depths only if requested.
RegionPrograms region_programs(const Shading& shading, bool wants_depths = false);

}  // namespace pxpl5::renderer
