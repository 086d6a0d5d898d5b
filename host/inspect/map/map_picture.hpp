// A map as a picture: its colours over what was drawn, and a legend below.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/inspect/map/map_values.hpp"

namespace pxpl5::host::inspect {

struct MapPicture {
    int width = 0, height = 0;
    std::vector<std::uint32_t> rgba;  ///< Red in the low byte; opaque.
};

struct MapStyle {
    bool grid = false;    ///< Lines between regions.
    std::string subject;  ///< Ends the legend's title, e.g. "frame 3".
};

/// The range of a map's values; {0, 0} if it has none. A count of primitives begins at 1, as 0 has
/// no colour.
struct MapRange {
    std::int64_t least = 0, most = 0;
};
MapRange range_of(const MapValues& map);

/// Draws the map. Pixels without a value, or without a primitive, show the picture, darkened and
/// grey.
MapPicture draw_map(const MapValues& map, const MapStyle& style);

/// "1234", "12.3k", "4.56M": as short as a legend needs.
std::string short_number(std::int64_t value);

}  // namespace pxpl5::host::inspect
