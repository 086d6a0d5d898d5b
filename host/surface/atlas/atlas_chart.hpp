// The isovalue atlas as a picture and as a table: what each isovalue would give, over the histogram
// of the volume's values.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "host/base/command_line.hpp"
#include "host/scene/marks.hpp"

namespace pxpl5::host {

/// Measures of the surface at one isovalue.
struct AtlasRow {
    double isovalue = 0;
    std::uint64_t triangles = 0;
    double area_mm2 = 0;
    double volume_mm3 = 0;
    std::uint64_t components = 0;
};

/// A range of isovalues in which the surface changes little.
struct AtlasPlateau {
    double from = 0, to = 0;  ///< Isovalues, ascending, both within.
    friend bool operator==(const AtlasPlateau&, const AtlasPlateau&) = default;
};

/// How often the volume's values fall into bins of equal width.
struct AtlasHistogram {
    double low = 0, high = 0;           ///< Lower edge of the first bin, upper edge of the last.
    std::vector<std::uint64_t> counts;  ///< One count per bin.
};

struct AtlasContent {
    std::string title;                   ///< Volume and case table; UTF-8, one line.
    std::vector<AtlasRow> rows;          ///< 2 or more, by ascending isovalue.
    AtlasHistogram histogram;            ///< Drawn if it has counts.
    std::vector<AtlasPlateau> plateaus;  ///< Ascending.
    std::string value_unit;              ///< "HU" for CT; empty if the values have none.
};

/// A chart: marks over a picture of one color.
struct AtlasChart {
    Size size;
    MarkColor background;
    std::vector<PictureMark> marks;
};

inline constexpr Size atlas_chart_size{1280, 860};

/// Draws the four measures over one axis of isovalues, each in a panel of its own with its unit,
/// the histogram (of logarithmic height) behind them and the plateaus shaded and numbered.
///
/// size   Pixels, each side atlas_chart_least_px or more; texts grow with it.
/// Throws RequestError for fewer than 2 rows, or rows that do not ascend.
AtlasChart atlas_chart(const AtlasContent& content, Size size = atlas_chart_size);

inline constexpr int atlas_chart_least_px = 560;  ///< Less, and its texts cannot be read.

/// The atlas as a table for the terminal: at most `most` rows, evenly chosen with the first and the
/// last, and then the plateaus.
std::string atlas_text(const AtlasContent& content, std::size_t most = 32);

}  // namespace pxpl5::host
