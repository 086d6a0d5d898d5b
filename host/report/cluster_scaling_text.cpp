#include <fmt/format.h>

#include <cmath>

#include "generated/vocabulary.hpp"
#include "host/base/chart_axis.hpp"
#include "host/base/text_table.hpp"
#include "host/machine/modelled_topology.hpp"
#include "host/report/cluster_scaling.hpp"
#include "host/report/scaling.hpp"

namespace pxpl5::host::report {

namespace {

using RateOf = ClusterRate ClusterPoint::*;

struct ClusterFigure {
    RateOf rate;
    timing::Lever ClusterSeries::*lever;
    std::string_view heading, subject;
};
constexpr ClusterFigure figures[] = {
    {&ClusterPoint::frames, &ClusterSeries::frames_lever, "frames/s", "frames"},
    {&ClusterPoint::thresholds, &ClusterSeries::thresholds_lever, "thresholds/s", "thresholds"}};

template <typename Cell>
TableRow row_of(const std::string& name, const ClusterSeries& series, const Cell& cell) {
    TableRow row{name};
    for (std::size_t i = 0; i < series.points.size(); ++i) {
        row.push_back(cell(series.points[i], i));
    }
    return row;
}

std::string table_of(const ClusterSeries& series, bool is_weak) {
    const auto number = [](double value) {
        return fmt::format("{:.{}f}", value, value < 99.95 ? 1 : 0);
    };
    std::vector<TableRow> rows;
    for (const ClusterFigure& figure : figures) {
        const std::vector<double> relative = series.relative(figure.rate);
        rows.push_back(row_of(fmt::format("  {}", figure.heading), series,
                              [&](const ClusterPoint& point, std::size_t) {
                                  return number((point.*figure.rate).per_s);
                              }));
        rows.push_back(row_of(is_weak ? "    of one computer's" : "    speed-up", series,
                              [&](const ClusterPoint&, std::size_t i) {
                                  return fmt::format("{:.2f}", relative[i]);
                              }));
        rows.push_back(row_of("    limit", series, [&](const ClusterPoint& point, std::size_t) {
            return std::string(name_of((point.*figure.rate).limit));
        }));
    }
    rows.push_back(
        row_of("  MB/frame between computers", series,
               [&](const ClusterPoint& point, std::size_t) { return number(point.network_mb); }));
    return text_table(row_of("  computers", series,
                             [](const ClusterPoint& point, std::size_t) {
                                 return fmt::format("{}", point.computers);
                             }),
                      rows);
}

/// Where one figure stops to grow, and what would help there.
struct End {
    End(const ClusterSeries& series, bool is_weak, const ClusterFigure& figure)
        : relative(series.relative(figure.rate)),
          at(end_of_growth(relative, is_weak)),
          last(at.value_or(series.points.size() - 1)),
          computers(series.points[last].computers),
          limited(series.points[std::min(last + 1, series.points.size() - 1)]),
          limit(name_of((limited.*figure.rate).limit)),
          lever(series.*figure.lever) {}

    std::vector<double> relative;
    std::optional<std::size_t> at;
    std::size_t last;
    std::uint32_t computers;
    ClusterPoint limited;
    std::string_view limit;
    timing::Lever lever;
};

std::string in_words(const End& end, bool is_weak, std::string_view subject) {
    const std::string computers = counted(end.computers, "computer");
    const double rate = end.relative[end.last];
    std::string text = fmt::format("  {}: ", subject);
    if (is_weak && end.at) {
        text += end.last == 0
                    ? fmt::format("less than half the rate of one computer with {} computers",
                                  end.limited.computers)
                    : fmt::format("at least half the rate of one computer up to {}", computers);
    } else if (is_weak) {
        text += fmt::format("{:.2f} of the rate of one computer with {}", rate, computers);
    } else if (end.at && end.last == 0) {
        text += "no faster with more computers";
    } else {
        text += fmt::format("{:.1f} times as fast with {} as with one{}", rate, computers,
                            end.at ? ", where it saturates" : "");
    }
    text += fmt::format("; limit with {}: {}", end.limited.computers, end.limit);
    return text + (end.lever.gain < least_gain
                       ? "; no single parameter moves it\n"
                       : fmt::format("; {} moves it most: {:.0f} % more\n", end.lever.change,
                                     100 * end.lever.gain));
}

std::string text_of(const std::string& name, const ClusterSeries& series, bool is_weak) {
    std::string text =
        fmt::format("{}, {}\n", name,
                    is_weak ? "weak: the slabs grow with the computers, the picture stays"
                            : "strong: the same volume and picture");
    text += table_of(series, is_weak);
    for (const ClusterFigure& figure : figures) {
        text += in_words(End(series, is_weak, figure), is_weak, figure.subject);
    }
    return text + "\n";
}

std::string parameters_text(const timing::Cluster& cluster) {
    std::vector<TableRow> rows;
    for (const timing::ClusterRow& row : timing::cluster_rows()) {
        rows.push_back({std::string(row.name), std::string(row.unit),
                        fmt::format("{:g}", cluster.*row.value), fmt::format("{:g}", row.least),
                        fmt::format("{:g}", row.most), std::string(row.source)});
    }
    return text_table({"parameter", "unit", "value", "least", "most", "source of the usual value"},
                      rows, 2);
}

}  // namespace

std::string text_of(const ClusterScaling& scaling) {
    std::string text = parameters_text(scaling.cluster);
    text += fmt::format(
        "\non each computer: {} and {}, at most {} of each in all; machines that run have at most "
        "{}, "
        "so more than {} are a forecast\n\n",
        counted(scaling.gps, "GP"), counted(scaling.renderers, "Renderer"), max_modelled_nodes,
        max_nodes_per_role, counted(max_nodes_per_role / scaling.gps, "computer"));
    for (const ClusterScalingRow& row : scaling.rows) {
        text += text_of(row.name, row.strong, false) + text_of(row.name, row.weak, true);
    }
    return text;
}

std::vector<Fields> ends_of(const ClusterScaling& scaling) {
    std::vector<Fields> list;
    for (const ClusterScalingRow& row : scaling.rows) {
        for (const bool is_weak : {false, true}) {
            for (const ClusterFigure& figure : figures) {
                const End end(is_weak ? row.weak : row.strong, is_weak, figure);
                list.push_back({{"row", row.name},
                                {"scaling", std::string(is_weak ? "weak" : "strong")},
                                {"figure", std::string(figure.subject)},
                                {"ends", end.at.has_value()},
                                {"computers", std::int64_t{end.computers}},
                                {"relative", end.relative[end.last]},
                                {"limit", std::string(end.limit)},
                                {"limit_with", std::int64_t{end.limited.computers}},
                                {"lever", end.lever.change},
                                {"lever_gain_percent", 100 * end.lever.gain}});
            }
        }
    }
    return list;
}

std::vector<Fields> fields_of(const ClusterScaling& scaling) {
    std::vector<Fields> list;
    for (const ClusterScalingRow& row : scaling.rows) {
        for (const bool is_weak : {false, true}) {
            const ClusterSeries& series = is_weak ? row.weak : row.strong;
            const std::vector<double> frames = series.relative(&ClusterPoint::frames);
            const std::vector<double> thresholds = series.relative(&ClusterPoint::thresholds);
            for (std::size_t i = 0; i < series.points.size(); ++i) {
                const ClusterPoint& point = series.points[i];
                list.push_back(
                    {{"row", row.name},
                     {"scaling", std::string(is_weak ? "weak" : "strong")},
                     {"computers", std::int64_t{point.computers}},
                     {"gps", std::int64_t{nodes_on(point.computers, scaling.gps)}},
                     {"renderers", std::int64_t{nodes_on(point.computers, scaling.renderers)}},
                     {"frames_per_s", point.frames.per_s},
                     {"frames_relative", frames[i]},
                     {"frames_limit", std::string(name_of(point.frames.limit))},
                     {"thresholds_per_s", point.thresholds.per_s},
                     {"thresholds_relative", thresholds[i]},
                     {"thresholds_limit", std::string(name_of(point.thresholds.limit))},
                     {"network_mb", point.network_mb}});
            }
        }
    }
    return list;
}

}  // namespace pxpl5::host::report
