#include "host/surface/plateaus.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace pxpl5::host {

namespace {

/// Change from a to b, the same both ways; infinite from or to nothing.
double relative_change(double a, double b) {
    if (a == b) return 0;
    if (a <= 0 || b <= 0) return std::numeric_limits<double>::infinity();
    return std::abs(std::log(b / a));
}

/// The greater of the changes of triangles and volume.
double change(const IsovalueRow& a, const IsovalueRow& b) {
    return std::max(
        relative_change(static_cast<double>(a.triangles), static_cast<double>(b.triangles)),
        relative_change(a.volume_mm3, b.volume_mm3));
}

}  // namespace

std::vector<Plateau> find_plateaus(std::span<const IsovalueRow> rows) {
    std::vector<Plateau> plateaus;
    if (rows.size() < 2) return plateaus;
    const double range = rows.back().isovalue - rows.front().isovalue;
    const double width = least_plateau_width * range;
    if (!(width > 0)) return plateaus;
    // A row is flat if some stretch of least width that holds it changes little from end to end.
    std::vector<double> best(rows.size(), std::numeric_limits<double>::infinity());
    for (std::size_t first = 0, last = 0; first < rows.size(); ++first) {
        while (last < rows.size() && rows[last].isovalue - rows[first].isovalue < width) ++last;
        if (last == rows.size()) break;
        if (rows[first].triangles == 0) continue;
        const double slope =
            change(rows[first], rows[last]) * width / (rows[last].isovalue - rows[first].isovalue);
        for (std::size_t i = first; i <= last; ++i) best[i] = std::min(best[i], slope);
    }
    for (std::size_t first = 0, next = 0; first < rows.size(); first = next + 1) {
        next = first;
        while (next < rows.size() && best[next] <= greatest_plateau_change) ++next;
        if (next == first) continue;
        Plateau plateau;
        plateau.name = fmt::format("P{}", plateaus.size() + 1);
        plateau.first = first;
        plateau.last = next - 1;
        plateau.from = rows[first].isovalue;
        plateau.to = rows[next - 1].isovalue;
        plateaus.push_back(plateau);
    }
    return plateaus;
}

}  // namespace pxpl5::host
