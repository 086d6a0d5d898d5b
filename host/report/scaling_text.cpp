#include <fmt/format.h>

#include <cmath>

#include "host/base/text_table.hpp"
#include "host/report/scaling.hpp"

namespace pxpl5::host::report {

namespace {

/// The growing and the constant parts of a series.
struct Growing {
    std::string_view what;  ///< "GPs"
    std::string beside;     ///< "16 Renderers"
};

/// Rounded to a tenth, so that next to nothing has no sign.
double tenths(double value) {
    return std::round(value * 10) / 10 + 0.0;
}

template <typename Cell>
TableRow row_of(const std::string& name, const ScalingSeries& series, const Cell& cell) {
    TableRow row{name};
    for (std::size_t i = 0; i < series.points.size(); ++i) {
        row.push_back(cell(i));
    }
    return row;
}

std::string table_of(const ScalingSeries& series, const Growing& growing) {
    const std::vector<double> build = series.build_speed_up(), frames = series.frames_speed_up();
    const auto& points = series.points;
    const auto number = [](double value) {
        return fmt::format("{:.{}f}", value, value < 99.95 ? 1 : 0);
    };
    const auto factor = [](double value) { return fmt::format("{:.2f}", value); };
    return text_table(
        row_of("  " + std::string(growing.what), series,
               [&](std::size_t i) { return fmt::format("{}", points[i].count); }),
        {row_of("  surface built in, ms", series,
                [&](std::size_t i) { return number(points[i].build_ms); }),
         row_of("    speed-up", series, [&](std::size_t i) { return factor(build[i]); }),
         row_of("    limit", series,
                [&](std::size_t i) { return std::string(name_of(points[i].build_limit)); }),
         row_of("  frames/s", series,
                [&](std::size_t i) { return number(points[i].frames_per_s); }),
         row_of("    speed-up", series, [&](std::size_t i) { return factor(frames[i]); }),
         row_of("    limit", series,
                [&](std::size_t i) { return std::string(name_of(points[i].frames_limit)); })});
}

/// Where one figure stops to grow.
std::string in_words(const ScalingSeries& series, const std::vector<double>& speed_up,
                     timing::Unit ScalingPoint::*limit, const Growing& growing,
                     std::string_view subject) {
    const std::optional<std::size_t> at = saturation(speed_up);
    if (!at) {
        const ScalingPoint& last = series.points.back();
        return fmt::format("  {} {:.1f} times as fast with {} {} as with one; limit there: {}\n",
                           subject, speed_up.back(), last.count, growing.what,
                           name_of(last.*limit));
    }
    const double gain_percent = tenths((speed_up[*at + 1] / speed_up[*at] - 1) * 100);
    const std::string_view limit_there = name_of(series.points[*at + 1].*limit);
    if (*at == 0) {
        return fmt::format("  {} no faster with more {}: twice as many gain {:.1f} %; limit: {}\n",
                           subject, growing.what, gain_percent, limit_there);
    }
    return fmt::format(
        "  {} {:.1f} times as fast with {} {} as with one, where it saturates: twice as many gain "
        "{:.1f} %; limit: {}\n",
        subject, speed_up[*at], series.points[*at].count, growing.what, gain_percent, limit_there);
}

std::string text_of(const std::string& name, const ScalingSeries& series, const Growing& growing) {
    return fmt::format("{}, {}\n", name, growing.beside) + table_of(series, growing) +
           in_words(series, series.build_speed_up(), &ScalingPoint::build_limit, growing,
                    "surface built") +
           in_words(series, series.frames_speed_up(), &ScalingPoint::frames_limit, growing,
                    "frames shown") +
           "\n";
}

Fields fields_of(const std::string& name, const ScalingReport& report, const ScalingPoint& point,
                 bool are_gps, double build_speed_up, double frames_speed_up) {
    return {{"row", name},
            {"gps", std::int64_t{are_gps ? point.count : report.gps}},
            {"renderers", std::int64_t{are_gps ? report.renderers : point.count}},
            {"build_ms", point.build_ms},
            {"build_speed_up", build_speed_up},
            {"build_limit", std::string(name_of(point.build_limit))},
            {"frames_per_s", point.frames_per_s},
            {"frames_speed_up", frames_speed_up},
            {"frames_limit", std::string(name_of(point.frames_limit))}};
}

}  // namespace

std::string text_of(const ScalingReport& report) {
    std::string text;
    for (const ScalingRow& row : report.rows) {
        text += text_of(row.name, row.gps, {"GPs", fmt::format("{} Renderers", report.renderers)});
        text += text_of(row.name, row.renderers, {"Renderers", fmt::format("{} GPs", report.gps)});
    }
    return text;
}

std::vector<Fields> fields_of(const ScalingReport& report) {
    std::vector<Fields> list;
    for (const ScalingRow& row : report.rows) {
        for (const bool are_gps : {true, false}) {
            const ScalingSeries& series = are_gps ? row.gps : row.renderers;
            const std::vector<double> build = series.build_speed_up();
            const std::vector<double> frames = series.frames_speed_up();
            for (std::size_t i = 0; i < series.points.size(); ++i) {
                list.push_back(
                    fields_of(row.name, report, series.points[i], are_gps, build[i], frames[i]));
            }
        }
    }
    return list;
}

}  // namespace pxpl5::host::report
