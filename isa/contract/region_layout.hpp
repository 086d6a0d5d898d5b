// The fields of a pixel's 208 bits while a region is drawn.
//
// The prologue of the Renderers clears these fields. The triangle programs of the Graphics
// Processors write them, and the end-of-region programs read them. All fields that a triangle
// writes are in two 32-bit columns.
#pragma once

#include <cstdint>

#include "generated/vocabulary.hpp"

namespace pxpl5::isa::region {

struct Field {
    std::uint32_t address;  ///< First bit in pixel memory.
    std::uint32_t width;    ///< Bits.
};

inline constexpr Field surface{0, 8};  ///< 0: background, else 1 + surface index.
inline constexpr Field z{8, 24};       ///< 0: near, all ones: far (background).
inline constexpr Field normal_x{32,
                                10};  ///< Eye space, signed, not normalized; 510 is unit length.
inline constexpr Field normal_y{42, 10};
inline constexpr Field normal_z{52, 10};
inline constexpr Field rgb{64, 24};  ///< Red in the low byte. The readout sends this field.
inline constexpr std::uint32_t scratch =
    88;  ///< First bit of scratch memory; see also screen_door.hpp.

inline constexpr std::uint32_t z_fraction_bits =
    8;  ///< Fraction bits of z planes: z and fraction fit 32 bits.
inline constexpr std::uint32_t normal_fraction_bits = 16;  ///< Fraction bits of normal planes.
inline constexpr std::int32_t normal_unit = 510;  ///< Length of a unit normal in field units.
inline constexpr std::uint32_t z_far = (1U << 24) - 1;
/// A pixel's depth where no surface is, as it is read out: z above the surface field.
inline constexpr std::uint32_t background_depth = z_far << surface.width;
inline constexpr std::uint32_t z_margin = 1U
                                          << 10;  ///< Drawn z are in z_margin .. z_far - z_margin.
inline constexpr int subpixel_bits = 4;           ///< Vertices are snapped to 1/16 pixel.

}  // namespace pxpl5::isa::region
