// A large picture in parts of whole regions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "host/scene/scene.hpp"

namespace pxpl5::host {

/// A part, and its size.
struct SizedPart {
    PicturePart place;
    Size size;
};

/// The parts of a picture, row by row, as large as they may be.
///
/// most_regions  That a part may have; 1 or more.
std::vector<SizedPart> parts_of(Size whole, std::size_t most_regions);

/// Copies the pixels of a part into the pixels of the picture: view by view, rows from the top.
void put_part(const SizedPart& part, std::span<const std::uint32_t> from,
              std::span<std::uint32_t> into);

}  // namespace pxpl5::host
