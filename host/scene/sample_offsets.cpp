#include "host/scene/sample_offsets.hpp"

#include <cassert>

namespace pxpl5::host {

namespace {

constexpr std::array<glm::ivec2, 4> of_4 = {{{-2, -6}, {6, -2}, {2, 6}, {-6, 2}}};
constexpr std::array<glm::ivec2, 16> of_16 = {{{-3, 1},
                                               {6, 8},
                                               {3, -1},
                                               {-4, -5},
                                               {7, 2},
                                               {-2, 7},
                                               {1, 3},
                                               {-7, -2},
                                               {2, -7},
                                               {-6, -8},
                                               {-5, 4},
                                               {-1, -3},
                                               {4, 5},
                                               {5, -4},
                                               {-8, 6},
                                               {8, -6}}};

}  // namespace

glm::ivec2 sample_offset(Pass pass) {
    assert(pass.sample >= 0 && pass.sample < pass.samples);
    const auto sample = static_cast<std::size_t>(pass.sample);
    return pass.samples == 1 ? glm::ivec2(0) : pass.samples == 4 ? of_4[sample] : of_16[sample];
}

}  // namespace pxpl5::host
