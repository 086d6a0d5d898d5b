#include "host/surface/atlas/plateaus.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pxpl5::host {

namespace {

/// The same both ways; infinite from or to nothing.
double relative_change(double a, double b) {
    if (a <= 0 || b <= 0) return std::numeric_limits<double>::infinity();
    return std::abs(std::log(b / a));
}

/// The greater of the changes of triangles and volume.
double change(const AtlasRow& a, const AtlasRow& b) {
    return std::max(
        relative_change(static_cast<double>(a.triangles), static_cast<double>(b.triangles)),
        relative_change(a.volume_mm3, b.volume_mm3));
}

}  // namespace

std::vector<AtlasPlateau> find_plateaus(std::span<const AtlasRow> rows) {
    std::vector<AtlasPlateau> plateaus;
    if (rows.empty()) return plateaus;
    const double width = least_plateau_width * (rows.back().isovalue - rows.front().isovalue);
    std::size_t end = 0;  // After the last row of the last plateau.
    for (std::size_t first = 0, last = 1; first < rows.size(); ++first) {
        last = std::max(last, first + 1);
        while (last < rows.size() && rows[last].isovalue - rows[first].isovalue < width) ++last;
        if (last == rows.size()) break;
        // Where rows are far apart, their step is wider than it needs to be.
        const double steps = (rows[last].isovalue - rows[first].isovalue) / width;
        if (change(rows[first], rows[last]) > greatest_plateau_change * steps) continue;
        if (plateaus.empty() || first >= end) plateaus.push_back({rows[first].isovalue, 0});
        plateaus.back().to = rows[last].isovalue;
        end = last + 1;
    }
    return plateaus;
}

}  // namespace pxpl5::host
