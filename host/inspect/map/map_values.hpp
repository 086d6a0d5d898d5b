// Maps of a frame: one exact number per pixel of the picture, by executing its regions again.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host/inspect/map/region_census.hpp"
#include "host/inspect/record/recorded_run.hpp"

namespace pxpl5::host::inspect {

enum class MapKind : std::uint8_t {
    idle,       ///< Instructions of its region that began while the pixel was disabled.
    busy,       ///< Instructions that began while the pixel was enabled.
    covered,    ///< Primitives whose edges hold it: those that had it enabled when they first used
                ///< its memory, which triangles do for the depth test.
    overdraw,   ///< Primitives that wrote it.
    cost,       ///< Modelled cycles of its region.
    gp,         ///< GP that drew the visible surface.
    renderer,   ///< Renderer of its region.
    cell_case,  ///< Class of the marching-cubes case of the visible triangle, 0..14.
    slab,       ///< Slab of the visible surface.
    depth,      ///< z of the visible surface.
    normal,     ///< Its normal: x, y and z, ten bits each, as pixel memory holds it.
};

/// The meaning of a map's numbers.
enum class MapScale : std::uint8_t { count, category, direction };

struct MapInfo {
    MapKind kind;
    std::string_view name;  ///< On the command line.
    MapScale scale;
    bool per_region;  ///< All pixels of a region have one value.
    std::string_view title;
    std::string_view unit;  ///< Unit of a count, or name of a category.
};
std::span<const MapInfo> map_kinds();
const MapInfo& info(MapKind kind);
/// Throws RequestError (usage) that lists the names.
MapKind map_kind_of(std::string_view name);

/// No value: background, or a region that was not recorded.
inline constexpr std::int64_t no_value = -1;

struct MapValues {
    MapKind kind{};
    int width = 0, height = 0;           ///< Size of the whole picture, views stacked.
    std::vector<std::int64_t> values;    ///< Row by row.
    std::vector<std::uint32_t> picture;  ///< The drawn picture, red in the low byte.
};

/// Throws RequestError (bad_data) if the map needs provenance that was not recorded.
MapValues map_values(const RecordedFrame& frame, MapKind kind);

/// The same without executing: `census` by region number.
MapValues map_values(const RecordedFrame& frame, MapKind kind,
                     const std::map<std::uint32_t, RegionCensus>& census);

/// One line per row of the picture, values separated by commas; nothing where there is no value. A
/// normal is "x:y:z", signed.
std::string to_csv(const MapValues& map);

/// Class of the case: sets of inside corners that rotations of the cell and swapping inside and
/// outside make equal are one. Numbers as in the paper's figure of 15 cases.
/// inside  Bit c: corner c, at (c & 1, c >> 1 & 1, c >> 2), is inside.
/// Source: Lorensen and Cline 1987, figure 3.
int case_class(std::uint8_t inside);

}  // namespace pxpl5::host::inspect
