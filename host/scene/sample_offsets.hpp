// A picture that is drawn several times: which frames it is the mean of, and where their pixels
// lie.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec2.hpp>

#include "ringbus/rules/pass.hpp"

namespace pxpl5::host {

/// Where the pass samples each pixel, seen from its center, in sixteenths of a pixel: x to the
/// right, y down. Over all passes of a picture the offsets sum up to 0. No two have a coordinate in
/// common, so that a nearly upright or level edge has as many steps as there are samples; whole
/// steps of the GPs' grid, so that each pass draws the same triangles, moved.
/// Source  4: the rotated grid; 16: ours, of all patterns that are symmetric about the center and
///         have one sample in each of 4 x 4, 2 x 8 and 8 x 2 cells, one with the largest least
///         distance; in an order in which each lies far from those before it.
glm::ivec2 sample_offset(Pass pass);

}  // namespace pxpl5::host
