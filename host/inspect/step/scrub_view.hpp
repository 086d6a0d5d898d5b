// The view of a region while its instructions are executed one by one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace pxpl5::host::inspect {

/// Where to stand, and what to show of the pixels.
struct ScrubWish {
    /// Instructions that have been executed; negative or more than there are: all of them.
    std::int64_t at = -1;
    /// A name of region_picture.hpp ("normal", "z", "64:24"). Empty: "rgb" in the end-of-region
    /// program and behind it, "normal" before, where no color is computed yet.
    std::string field;
};

/// One instruction that is executed, in the order in which it is.
struct ScrubLine {
    std::uint64_t at = 0;  ///< How many are executed before it.
    std::string address;   ///< "gp-0 surface 0 slab 17+34".
    std::string text;      ///< The instruction as assembly.
    std::string meaning;   ///< Meaning of the instruction, from ISA.md.
    std::string effect;    ///< On the pixel that was asked about: "z 16777215 -> 81920"; may be "".
};

struct ScrubView {
    std::uint64_t at = 0, count = 0;  ///< Instructions executed, and of the region.
    std::uint32_t region = 0, renderer = 0;
    int x0_px = 0, y0_px = 0;         ///< Top left pixel of the region in the picture.
    std::vector<ScrubLine> lines;     ///< Around `at`: the next to be executed has it as its `at`.
    std::size_t enabled = 0;          ///< Pixels.
    std::string field;                ///< Field in `rgba`.
    std::vector<std::uint32_t> rgba;  ///< 128 x 128, red in the low byte; alpha 255, 254: disabled.
};

}  // namespace pxpl5::host::inspect
