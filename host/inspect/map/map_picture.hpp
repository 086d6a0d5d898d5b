// A map as a picture: colors over the drawn frame, and a legend below.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/inspect/map/map_values.hpp"
#include "host/scene/marks.hpp"

namespace pxpl5::host::inspect {

struct MapPicture {
    int width = 0, height = 0;
    std::vector<std::uint32_t> rgba;  ///< Red in the low byte; opaque.
    std::vector<PictureMark> marks;   ///< Grid, labels and legend.
};

struct MapStyle {
    bool grid = false;    ///< Lines between regions.
    std::string subject;  ///< Ends the legend's title, e.g. "frame 3".
};

/// The range of a map's values; {0, 0} if it has none. A count of primitives begins at 1, because
/// 0 has no color.
struct MapRange {
    std::int64_t least = 0, most = 0;
};
MapRange range_of(const MapValues& map);

/// Draws the map. Pixels without a value or a primitive show the frame in dark gray.
MapPicture draw_map(const MapValues& map, const MapStyle& style);

/// "1234", "12.3k", "4.56M": as short as a legend needs.
std::string short_number(std::int64_t value);

}  // namespace pxpl5::host::inspect
