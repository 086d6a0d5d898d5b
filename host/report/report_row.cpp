#include "host/report/report_row.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "host/base/chart_axis.hpp"
#include "host/base/text_table.hpp"

namespace pxpl5::host::report {

namespace {

/// With a mark if it is beyond its bound.
std::string error_text(const Figure& figure, bool within) {
    return fmt::format("{:+.1f}{}", figure.error_percent(), within ? " " : "!");
}

TableRow cells_of(const ReportRow& row) {
    const Figure& build = row.build_ms;
    const Figure& frames = row.frames_per_s;
    return {row.name + (row.held_back ? " *" : ""),
            grouped(static_cast<double>(row.paper_triangles)),
            grouped(static_cast<double>(row.triangles)),
            fmt::format("{:.0f}", build.paper),
            fmt::format("{:.0f}", build.modelled),
            error_text(build, row.build_within()),
            std::string(timing::name_of(build.limit)),
            fmt::format("{:.1f}", build.wall),
            fmt::format("{:.0f}", frames.paper),
            fmt::format("{:.1f}", frames.modelled),
            error_text(frames, row.frames_within()),
            std::string(timing::name_of(frames.limit)),
            fmt::format("{:.1f}", frames.wall)};
}

/// Columns that belong together.
struct ColumnGroup {
    std::string_view title;
    std::size_t first = 0, count = 0;
};
constexpr std::array groups{ColumnGroup{"triangles", 1, 2},
                            ColumnGroup{"surface built in, ms", 3, 5},
                            ColumnGroup{"frames/s", 8, 5}};
const TableRow row_heading{"",     "paper", "here",     "paper",    "modelled", "error, %", "limit",
                           "wall", "paper", "modelled", "error, %", "limit",    "wall"};

/// Titles over the columns of text_table().
std::string group_line(const std::vector<TableRow>& rows) {
    constexpr std::size_t gap = 2;
    std::vector<std::size_t> ends;
    for (std::size_t column = 0; column < row_heading.size(); ++column) {
        std::size_t width = row_heading[column].size();
        for (const TableRow& row : rows) {
            width = std::max(width, row[column].size());
        }
        ends.push_back((ends.empty() ? 0 : ends.back() + gap) + width);
    }
    std::string line;
    for (const ColumnGroup& group : groups) {
        const std::size_t begin = ends[group.first - 1] + gap;
        const std::size_t width = ends[group.first + group.count - 1] - begin;
        line += std::string(begin - line.size(), ' ') +
                fmt::format("{:-^{}}", fmt::format(" {} ", group.title), width);
    }
    return line + "\n";
}

/// `modelled` says the figure.
std::string beyond_text(const ReportRow& row, const Figure& figure, const std::string& modelled,
                        double bound_percent, const std::string& reason) {
    return fmt::format("{}: {}, {:.1f} % {} than the paper's {:.0f}, beyond {:.0f} %: {}\n",
                       row.name, modelled, std::abs(figure.error_percent()),
                       figure.error_percent() < 0 ? "less" : "more", figure.paper, bound_percent,
                       reason);
}

void add_fields(Fields& fields, const std::string& name, const Figure& figure, bool within,
                const std::string& reason) {
    fields.push_back({"paper_" + name, figure.paper});
    fields.push_back({"modelled_" + name, figure.modelled});
    fields.push_back({name + "_error_percent", figure.error_percent()});
    fields.push_back({name + "_within", within});
    fields.push_back({name + "_limit", std::string(timing::name_of(figure.limit))});
    fields.push_back({name + "_limit_share", figure.limit_share});
    fields.push_back({name + "_reason", reason});
    fields.push_back({"wall_" + name, figure.wall});
}

BarPlot bars_of(const std::vector<ReportRow>& rows, Figure ReportRow::*which) {
    BarPlot plot;
    plot.series = {{"paper", {}}, {"modelled", {}}, {"wall time, here", {}}};
    for (const ReportRow& row : rows) {
        // Blanks let a name be broken into lines.
        std::string group = row.name;
        group.replace(group.find('/'), 1, " ");
        plot.groups.push_back(group + (row.held_back ? "\u00a0*" : ""));  // With the last word.
        const Figure& figure = row.*which;
        plot.series[0].values.emplace_back(figure.paper);
        plot.series[1].values.emplace_back(figure.modelled);
        plot.series[2].values.emplace_back(figure.wall);
    }
    return plot;
}

}  // namespace

bool ReportRow::build_within() const {
    return std::abs(build_ms.error_percent()) <= build_bound_percent;
}

bool ReportRow::frames_within() const {
    return std::abs(frames_per_s.error_percent()) <= frames_bound_percent;
}

std::string table_of(const std::vector<ReportRow>& rows) {
    std::vector<TableRow> cells;
    std::string beyond;
    for (const ReportRow& row : rows) {
        cells.push_back(cells_of(row));
        if (!row.build_within()) {
            beyond += beyond_text(row, row.build_ms,
                                  fmt::format("built in {:.0f} ms", row.build_ms.modelled),
                                  build_bound_percent, row.build_reason);
        }
        if (!row.frames_within()) {
            beyond += beyond_text(row, row.frames_per_s,
                                  fmt::format("{:.1f} frames/s", row.frames_per_s.modelled),
                                  frames_bound_percent, row.frames_reason);
        }
    }
    return group_line(cells) + text_table(row_heading, cells) + beyond;
}

std::string text_of(const Footnote& footnote) {
    return fmt::format(
        "paper: 36 GPs, 16 Renderers, 1993, wall time of that machine, pictures of a size that is "
        "not stated\n"
        "modelled: {}; counts of the same work, replayed; pictures of {}x{}; limit: what was "
        "busy for {:.0f} % of the time or more, else waiting\n"
        "wall: wall time here, {}, pictures of {}x{}, every view newly drawn\n"
        "volumes: not the paper's own, but of its sizes and with its triangle loads\n"
        "*: held back from fitting the model's parameters; !: beyond {:.0f} % (built in), "
        "{:.0f} % (frames/s)\n",
        footnote.modelled, modelled_size.width, modelled_size.height,
        timing::least_limit_share * 100, footnote.drawn_by, wall_size.width, wall_size.height,
        build_bound_percent, frames_bound_percent);
}

Fields fields_of(const ReportRow& row) {
    Fields fields{{"row", row.name},
                  {"source", row.source},
                  {"held_back", row.held_back},
                  {"paper_triangles", row.paper_triangles},
                  {"triangles", row.triangles}};
    add_fields(fields, "build_ms", row.build_ms, row.build_within(), row.build_reason);
    add_fields(fields, "frames_per_s", row.frames_per_s, row.frames_within(), row.frames_reason);
    return fields;
}

std::vector<Plot> plots_of(const std::vector<ReportRow>& rows) {
    BarPlot build = bars_of(rows, &ReportRow::build_ms);
    build.title = "Surface built in";
    build.y_label = "ms";
    BarPlot frames = bars_of(rows, &ReportRow::frames_per_s);
    frames.title = "Frames shown";
    frames.y_label = "frames/s";
    frames.note = fmt::format(
        "*: held back from fitting the model's parameters. Modelled: pictures of {}x{}; wall time: "
        "of {}x{}, on this computer.",
        modelled_size.width, modelled_size.height, wall_size.width, wall_size.height);
    return {build, frames};
}

}  // namespace pxpl5::host::report
