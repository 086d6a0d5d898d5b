// The programs that a region begins and ends with: clearing, and deferred Phong shading.
//
// The assembly text lies in renderer_firmware/programs/, with the register map; it is built into
// the binary and assembled at first use.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pxpl5::renderer {

inline constexpr std::size_t max_lights = 4;
inline constexpr std::size_t max_surfaces = 255;
inline constexpr std::uint32_t max_specular_power = 128;
inline constexpr float max_light_sum = 3.9F;  ///< Of ambient and all intensities; 1 is white.

/// Directional light in eye space: x right, y up, z towards the viewer.
struct Light {
    struct Direction {
        float x = 0, y = 0, z = 1;
    };
    Direction direction;  ///< Towards the light; of any length but 0.
    float intensity = 1;
};

struct Rgb {
    std::uint8_t r = 0, g = 0, b = 0;
};

/// Of a surface's pixels in each 4 x 4 of the picture, how many show it, and which.
struct Screen {
    std::uint32_t opacity = 16;  ///< 1..16 (isa::door::levels).
    /// Surfaces with the same one share pixels. Of 0, 1 and 2 any two are such that what is behind
    /// both is seen, and evenly. From 12 on they come again.
    std::uint32_t pattern = 0;
};

/// Which of the frames whose mean a picture is; by default the only one.
struct Pass {
    std::uint32_t sample = 0;   ///< From 0.
    std::uint32_t samples = 1;  ///< 1, 4 or 16.
    bool is_last() const { return sample + 1 == samples; }
};

/// How the pixels of a frame are lit. A pixel's colour is
///   surface * (ambient + sum I max(0, n.l)) + 255 * specular * sum I max(0, n.h)^power,
/// held at 255, with n turned to the viewer and h = normalise(l + (0, 0, 1)).
struct Shading {
    std::vector<Light> lights;  ///< 0..4.
    float ambient = 0.2F;
    float specular = 0.3F;              ///< 0..1.
    std::uint32_t specular_power = 20;  ///< 1..128.
    Rgb background;
    std::vector<Rgb> surfaces;  ///< Surface field s of a pixel has surfaces[s - 1]; 0..255 of them.
    std::vector<Screen> screens;  ///< Of each surface; those that are left out are opaque.
    Pass pass{};  ///< Screens move by a pixel a pass: over 16, each pixel has seen every rank.
};

/// Clears a region: every pixel background, far, without a normal. Throws as end_of_region().
std::vector<std::uint32_t> prologue(const Shading& shading);

/// Shades the covered pixels of a region and reads all out; of a pass, adds all to the sums of the
/// passes before, in the backing store, and keeps them or, the last, reads their mean out: each
/// channel's sum divided by the number of passes, halves up. Relies on prologue() of the same
/// shading. Normals are up to 512 field units long (isa::region::normal_unit is unit length); a
/// normal of length 0 gets the ambient light alone. Destroys normals and z. Throws
/// std::invalid_argument that names the value and its limit.
std::vector<std::uint32_t> end_of_region(const Shading& shading);

/// The same program for another region of the Renderer: each has blocks of its own for its sums.
/// end_of_region  Of a pass; names the blocks of slot 0.
/// slot           Below isa::max_summed_regions(samples).
std::vector<std::uint32_t> at_slot(std::vector<std::uint32_t> end_of_region, std::uint32_t samples,
                                   std::size_t slot);

/// What runs before and behind the segments of a transparent surface. Relies on prologue() of the
/// same shading.
struct DoorPrograms {
    std::uint32_t surface = 0;  ///< Index.
    std::vector<std::uint32_t> shut, open;
};

/// Those of all surfaces that are not opaque, ascending. Throws as end_of_region().
std::vector<DoorPrograms> doors(const Shading& shading);

/// Reads out, ahead of end_of_region(), the surface field (bits 0..7) and the depth (8..31).
std::vector<std::uint32_t> depths();

struct RegionPrograms {
    std::vector<std::uint32_t> prologue, end_of_region;
    std::vector<DoorPrograms> doors;
    std::vector<std::uint32_t> depths;  ///< Empty unless wanted.
};

/// All programs; that of depths only if they are wanted.
RegionPrograms region_programs(const Shading& shading, bool wants_depths = false);

}  // namespace pxpl5::renderer
