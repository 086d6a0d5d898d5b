// Sphere program: the instruction words of one sphere in one region.
//
// The instructions are as follows; e and j depend on the sphere and the region:
//
//    SETENABS
//    TREEgeZERO      :8               four times: within the bounding box, so that a Renderer can
//                                     skip the other pixels
//    QUADintoMEM     m[104]:48        form, its upper words: 48 bits from bit 16 on
//    CLEARMEM        m[88]:16
//    MEMpluseqQUAD   m[88]:64         and its lower 16 bits: the form times 2^e, in 64 bits
//    ENABandeqNOTMEM m[151]           inside if the form is not negative
//    SQRTMEM         m[root]:2j       S, j bits
//    MULCONST        m[152]:25 m[root]  depth: -root S ...
//    MEMpluseqTREE   m[152+j-8]:32      ... + plane
//    MEMltMEM        m[152+j]:24 m[z]
//    MEMintoMEM      m[152+j] m[z]:24
//    for each k: MULCONST m[152]:17 m[root]; MEMpluseqTREE m[152+j-8]:24;
//                MEMintoMEM m[152+j+6] m[normal_k]:10
//    IMMintoMEM      m[surface]:8 #number
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "gp_firmware/render/sphere_setup.hpp"

namespace pxpl5::gp {

inline constexpr std::size_t sphere_word_count = 64;
inline constexpr int max_root_bits = 16;  ///< Maximum of bits of S, a limit of SQRTMEM.

/// Returns the words that draw `sphere` into the region whose first pixel is (x0, y0).
///
/// surface_word  isa::triangle::surface_word() of the surface.
/// Returns       Nothing if the outline is too thin for 64 bits. Only a distorting camera makes
///               such an ellipse.
std::optional<std::array<std::uint32_t, sphere_word_count>> sphere_program(
    const ScreenSphere& sphere, int x0, int y0, std::uint32_t surface_word);

}  // namespace pxpl5::gp
