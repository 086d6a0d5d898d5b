#include <fmt/format.h>

#include <algorithm>

#include "host/base/chart_axis.hpp"
#include "host/base/text_table.hpp"
#include "host/surface/atlas/atlas_chart.hpp"

namespace pxpl5::host {

namespace {

/// Number of the plateau that holds the isovalue, or nothing.
std::string plateau_of(const AtlasContent& content, double isovalue) {
    for (std::size_t index = 0; index < content.plateaus.size(); ++index) {
        const AtlasPlateau& plateau = content.plateaus[index];
        if (plateau.from <= isovalue && isovalue <= plateau.to) {
            return fmt::format("{}", index + 1);
        }
    }
    return "";
}

}  // namespace

std::string atlas_text(const AtlasContent& content, std::size_t most) {
    const std::size_t count = content.rows.size(), shown = std::min(count, most);
    std::vector<TableRow> lines;
    for (std::size_t line = 0; line < shown; ++line) {
        const std::size_t index = shown > 1 ? line * (count - 1) / (shown - 1) : 0;
        const AtlasRow& row = content.rows[index];
        lines.push_back(
            {fmt::format("{:.6g}", row.isovalue), grouped(static_cast<double>(row.triangles)),
             fmt::format("{:.1f}", row.area_mm2 / 100),
             fmt::format("{:.2f}", row.volume_mm3 / 1000),
             grouped(static_cast<double>(row.components)), plateau_of(content, row.isovalue)});
    }
    std::string text =
        text_table({"isovalue", "triangles", "cm2", "ml", "components", "plateau"}, lines, 0);
    for (std::size_t index = 0; index < content.plateaus.size(); ++index) {
        text += fmt::format("plateau {}: isovalue {:.6g} to {:.6g}\n", index + 1,
                            content.plateaus[index].from, content.plateaus[index].to);
    }
    if (!text.empty()) {
        text.pop_back();  // A reply's text ends without a newline.
    }
    return text;
}

}  // namespace pxpl5::host
