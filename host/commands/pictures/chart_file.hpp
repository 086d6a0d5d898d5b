// Charts that a session's commands write.
#pragma once

#include <string>
#include <vector>

#include "host/scene/marks.hpp"
#include "host/session/session.hpp"

namespace pxpl5::host {

/// A chart: marks over a picture of one color.
struct ChartFile {
    Size size;  ///< Pixels.
    MarkColor paper;
    std::vector<PictureMark> marks;
    std::string description;  ///< UTF-8; goes into the file.
};

/// Writes the chart; the suffix selects the format. Throws RequestError.
void write_chart_file(Session& session, const ChartFile& chart, const std::string& path);

}  // namespace pxpl5::host
