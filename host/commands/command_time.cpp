// Commands about time series: time, cine, curve.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <optional>
#include <ranges>
#include <vector>

#include "host/base/answer.hpp"
#include "host/base/error.hpp"
#include "host/base/part_file.hpp"
#include "host/base/stopwatch.hpp"
#include "host/chart/plot.hpp"
#include "host/commands/command_handlers.hpp"
#include "host/commands/pictures/chart_file.hpp"
#include "host/commands/pictures/picture_files.hpp"
#include "host/commands/pictures/picture_settings.hpp"
#include "host/commands/text/volume_text.hpp"
#include "host/session/restore.hpp"

namespace pxpl5::host {

namespace {

/// Throws RequestError (usage) if the volume is no time series.
void check_series(const Volume& volume, const std::string& command) {
    if (volume.frames > 1) {
        return;
    }
    const auto copies =
        std::ranges::find(volume.findings, FindingKind::duplicate_slices, &Finding::kind);
    refuse_command(fmt::format("{}: {} is one volume; {}", command, volume.source,
                               copies == volume.findings.end()
                                   ? "load a file of several volumes, for example phantom:heart"
                                   : copies->text));
}

/// The volume nearest to a time after the first; of two that are as near, the earlier one.
int frame_at(const Volume& volume, double at_ms) {
    const std::optional<double> last_ms = time_ms(volume, volume.frames);
    if (!last_ms) {
        refuse_command(
            fmt::format("time: {} does not state the times of its volumes: give the "
                        "number of one, 1 to {}",
                        volume.source, volume.frames));
    }
    if (ms_text(at_ms) != ms_text(*last_ms) && at_ms > *last_ms) {
        refuse_command(fmt::format("time: at={} ms is beyond the last volume of {}: give 0 to {}",
                                   ms_text(at_ms), volume.source, ms_text(*last_ms)));
    }
    const auto distance = [&](int frame) { return std::abs(*time_ms(volume, frame) - at_ms); };
    return std::ranges::min(std::views::iota(1, volume.frames + 1), {}, distance);
}

/// The volume that the command names: a number, "next", "previous", or the one nearest to at=.
int wished_frame(const Volume& volume, const Arguments& arguments) {
    if (arguments.has("at")) {
        if (!arguments.words.empty()) {
            refuse_command("time: give the number of a volume or at=, not both");
        }
        return frame_at(volume, arguments.number("at", 0));
    }
    const std::string& word = arguments.words[0];
    if (word == "next") {
        return volume.frame % volume.frames + 1;
    }
    if (word == "previous") {
        return (volume.frame + volume.frames - 2) % volume.frames + 1;
    }
    if (word.empty() || word.find_first_not_of("0123456789-") != std::string::npos) {
        refuse_command(
            fmt::format("time: '{}' is no number of a volume, 'next' or 'previous'; {} "
                        "has volumes 1 to {}",
                        word, volume.source, volume.frames));
    }
    return parse_whole("time", word);
}

Reply describe_time(const Session& session) {
    const Volume& volume = session.volumes.volume();
    const std::optional<double> ms = time_ms(volume, volume.frame);
    const TimeSeries::Kept kept = session.series.kept();
    Reply reply{
        fmt::format("volume {} of {}{}; {} kept in memory ({:.1f} MiB)", volume.frame,
                    volume.frames, ms ? fmt::format(", at {} ms", ms_text(*ms)) : "",
                    counted(kept.volumes, "other"), static_cast<double>(kept.bytes) / (1 << 20)),
        {{"frame", std::int64_t{volume.frame}},
         {"frames", std::int64_t{volume.frames}},
         {"kept", static_cast<std::int64_t>(kept.volumes)},
         {"kept_bytes", static_cast<std::int64_t>(kept.bytes)}}};
    if (ms) {
        reply.fields.push_back({"time_ms", *ms});
    }
    return reply;
}

/// The volumes of a command that runs through the series.
struct Turn {
    int first = 1, last = 1;
    int count() const { return last - first + 1; }
};

Turn turn_of(const Session& session, const Arguments& arguments) {
    const Volume& volume = session.volumes.volume();
    check_series(volume, arguments.name);
    const Turn turn{parse_whole("from", arguments.text("from", "1")),
                    parse_whole("to", arguments.text("to", std::to_string(volume.frames)))};
    for (const auto& [option, frame] : {std::pair{"from", turn.first}, {"to", turn.last}}) {
        if (frame > volume.frames) {
            refuse_command(fmt::format("{}: {}={} is beyond the last volume of {}: give 1 to {}",
                                       arguments.name, option, frame, volume.source,
                                       volume.frames));
        }
    }
    if (turn.last < turn.first) {
        refuse_command(fmt::format("{}: to={} is before from={}: give to={} or more",
                                   arguments.name, turn.last, turn.first, turn.first));
    }
    return turn;
}

/// Shows one volume after the other, and at the end the scene of before, also after an error.
void run_through(Session& session, const Turn& turn, const std::function<void(int frame)>& act) {
    const Scene before = session.scene;
    try {
        for (int frame = turn.first; frame <= turn.last; ++frame) {
            show_frame(session, frame);
            act(frame);
        }
    } catch (const RequestError&) {
        go_back(session, before);
        throw;
    }
    go_back(session, before);
}

/// A surface at one time. The faces of the scan close it. Without a volume if it has no triangles,
/// or if components that its filter selects have holes.
struct Measured {
    int frame = 1;
    std::int64_t triangles = 0;
    double area_mm2 = 0;
    std::optional<double> volume_ml;
};

struct Curve {
    std::string surface;
    std::vector<Measured> rows;
};

/// Measures the components of the surface that its filter selects.
Measured measured(Session& session, const Surface& surface) {
    const SurfaceReport& report = session.surfaces.report_of(surface.name);
    Measured now{session.scene.frame, report.triangles, report.area_mm2, {}};
    if (report.triangles > 0) {  // Else all voxels are on one side, and the text names no side.
        now.volume_ml = report.volume_mm3 / 1000;
    }
    if (surface.components.kind != ComponentFilter::Kind::all) {
        const DrawnComponents drawn = session.meshes.components(surface);
        now.triangles = std::ranges::count(drawn.shown, 1);
        now.area_mm2 = drawn.area_mm2();
        now.volume_ml = drawn.volume_ml(OpenParts::closed_by_scan);
    }
    return now;
}

/// The rows with the largest and the least volume; nothing if a row has none.
struct Extremes {
    Measured largest, least;
    double ejected() const { return 1 - *least.volume_ml / *largest.volume_ml; }
};

std::optional<Extremes> extremes_of(const Curve& curve) {
    const auto volume = [](const Measured& row) { return row.volume_ml.value_or(0); };
    if (!std::ranges::all_of(curve.rows, [](const Measured& row) {
            return row.volume_ml.has_value() && *row.volume_ml > 0;
        })) {
        return std::nullopt;
    }
    // Of equal ones the first.
    return Extremes{*std::ranges::max_element(curve.rows, {}, volume),
                    *std::ranges::min_element(curve.rows, {}, volume)};
}

std::vector<Curve> curves_of(Session& session, const Turn& turn) {
    std::vector<Curve> curves;
    for (const Surface& surface : session.scene.surfaces) {
        if (surface.compared_with.empty()) {
            curves.push_back({surface.name, {}});
        }
    }
    if (curves.empty()) {
        refuse_command("curve: there is no surface to measure; add one first: surface NAME iso=V");
    }
    run_through(session, turn, [&](int frame) {
        for (Curve& curve : curves) {
            curve.rows.push_back(measured(session, *session.surfaces.find(curve.surface)));
        }
        if (session.tell_pictures) {
            session.tell_pictures(frame - turn.first + 1, turn.count());
        }
    });
    return curves;
}

Table table_of(const Volume& volume, const std::vector<Curve>& curves) {
    Table table{"rows",
                {{"surface", "surface"},
                 {"frame", "frame"},
                 {"time_ms", "time (ms)"},
                 {"triangles", "triangles"},
                 {"area_mm2", "area (mm2)"},
                 {"volume_ml", "volume (ml)"}}};
    for (const Curve& curve : curves) {
        for (const Measured& row : curve.rows) {
            table.rows.push_back(
                {curve.surface, row.frame, time_ms(volume, row.frame),
                 grouped_cell(static_cast<std::uint64_t>(row.triangles)),
                 fixed_cell(row.area_mm2, 1),
                 Cell(field_value(row.volume_ml),
                      row.volume_ml ? fmt::format("{:.3f}", *row.volume_ml) : "-")});
        }
    }
    return table;
}

/// "blood: largest ..., least ...; ejection fraction 60.4 %", of a part of the series "of volumes 8
/// to 13".
std::string summary_text(const Volume& volume, const Curve& curve) {
    const std::optional<Extremes> found = extremes_of(curve);
    if (!found) {
        return curve.surface + ": no volume at some time: no triangles, or parts with holes";
    }
    const auto at = [&](const Measured& row) {
        const std::optional<double> ms = time_ms(volume, row.frame);
        return fmt::format("{:.2f} ml (volume {}{})", *row.volume_ml, row.frame,
                           ms ? fmt::format(", {} ms", ms_text(*ms)) : "");
    };
    const auto count = static_cast<int>(curve.rows.size());
    if (count == 1) {
        return fmt::format("{}: {}", curve.surface, at(found->largest));
    }
    return fmt::format("{}: largest {}, least {}; ejection fraction {}{:.1f} %", curve.surface,
                       at(found->largest), at(found->least),
                       count < volume.frames
                           ? fmt::format("of volumes {} to {}: ", curve.rows.front().frame,
                                         curve.rows.back().frame)
                           : "",
                       100 * found->ejected());
}

/// Volume and area of each surface over time.
Chart curve_chart(const Volume& volume, const std::vector<Curve>& curves) {
    const bool has_time = time_ms(volume, 1).has_value();
    const PlotAxis x{has_time ? "time (ms)" : "frame", PlotScale::linear};
    std::string note;
    for (const Curve& curve : curves) {
        note += (note.empty() ? "" : "; ") + summary_text(volume, curve);
    }
    LinePlot volumes{volume.name, "", x, {"volume (ml)", PlotScale::linear}, {}};
    LinePlot areas{"", note, x, {"area (cm\u00b2)", PlotScale::linear}, {}};
    for (std::size_t i = 0; i < curves.size(); ++i) {
        PlotLine ml{curves[i].surface, {}, i, false, {}};
        PlotLine cm2{curves[i].surface, {}, i, false, {}};
        for (const Measured& row : curves[i].rows) {
            const double at = has_time ? *time_ms(volume, row.frame) : row.frame;
            if (row.volume_ml) {
                ml.points.push_back({at, *row.volume_ml});
            }
            cm2.points.push_back({at, row.area_mm2 / 100});
        }
        if (!ml.points.empty()) {
            volumes.lines.push_back(std::move(ml));
        }
        areas.lines.push_back(std::move(cm2));
    }
    std::vector<Plot> plots;
    if (!volumes.lines.empty()) {
        plots.emplace_back(std::move(volumes));
    }
    plots.emplace_back(std::move(areas));
    return chart_of(plots);
}

void write_curve(Session& session, const std::vector<Curve>& curves, const std::string& path) {
    const Volume& volume = session.volumes.volume();
    if (suffix_of(path) == ".csv") {
        const Table table = table_of(volume, curves);
        remove_abandoned_parts(path);
        PartFile file(path);
        file.write(csv_heading(table) + csv_rows(table));
        if (const std::string reason = file.keep(); !reason.empty()) {
            throw RequestError(ExitCode::failed,
                               fmt::format("curve: '{}' cannot be written: {}", path, reason));
        }
        return;
    }
    constexpr double enlarged = 2;
    const Chart chart = scaled(curve_chart(volume, curves), enlarged);
    write_chart_file(
        session,
        {{static_cast<int>(std::ceil(chart.width)), static_cast<int>(std::ceil(chart.height))},
         {255, 255, 255, 255},
         chart.marks,
         "surfaces of " + volume.name + " over time"},
        path);
}

Answer summary_of(const Volume& volume, const Curve& curve) {
    Answer answer;
    answer.line(summary_text(volume, curve)).data("name", curve.surface);
    if (const std::optional<Extremes> found = extremes_of(curve)) {
        answer.data("largest_ml", *found->largest.volume_ml)
            .data("largest_frame", found->largest.frame)
            .data("least_ml", *found->least.volume_ml)
            .data("least_frame", found->least.frame);
        if (curve.rows.size() > 1) {
            answer.data("ejection_fraction", found->ejected());
        }
    }
    return answer;
}

/// Films whose volumes are so far apart are in real time.
constexpr double least_real_ms = 1000 / film::max_rate, most_real_ms = 200;

}  // namespace

Reply run_time(Session& session, const Arguments& arguments) {
    const Volume& volume = session.volumes.volume();
    check_series(volume, arguments.name);
    if (arguments.words.empty() && !arguments.has("at")) {
        return describe_time(session);
    }
    const std::int64_t start_ns = now_ns();
    show_frame(session, wished_frame(volume, arguments));
    const double ms = ms_since(start_ns);
    Reply reply = describe_time(session);
    reply.text += fmt::format("; shown after {:.1f} ms", ms);
    reply.fields.push_back({"elapsed_ms", ms});
    return reply;
}

Reply run_cine(Session& session, const Arguments& arguments) {
    const Turn turn = turn_of(session, arguments);
    const PictureSettings settings(session.scene, arguments);
    if (settings.is_transparent()) {
        refuse_command(
            "cine: its pictures cannot have a transparent ground. Name a color: ground=white");
    }
    const double apart_ms = session.volumes.volume().frame_ms;
    const bool is_real = apart_ms >= least_real_ms && apart_ms <= most_real_ms;
    PictureFiles files(session, arguments, 0, turn.count(), is_real ? apart_ms : usual_delay_ms);
    files.set_volumes({turn.first, turn.last});
    const std::int64_t start_ns = now_ns();
    double elapsed_ms = 0;
    run_through(session, turn, [&](int frame) {
        files.take(frame - turn.first, session.frames.draw(), session.scene.camera);
        elapsed_ms = ms_since(start_ns);
    });
    files.finish();
    Reply reply{
        fmt::format("{} drawn in {:.0f} ms",
                    counted(static_cast<std::uint64_t>(turn.count()), "volume"), elapsed_ms),
        {{"volumes", std::int64_t{turn.count()}},
         {"elapsed_ms", elapsed_ms},
         {"written", files.written()}}};
    if (!files.has_interrupted()) {
        const double rate = turn.count() * 1000.0 / elapsed_ms;
        reply.text += fmt::format(", {:.1f}/s", rate);
        reply.fields.push_back({"volumes_per_s", rate});
    }
    files.add_files(reply);
    reply.text += files.text();
    files.warn(reply);
    return reply;
}

Reply run_curve(Session& session, const Arguments& arguments) {
    const Turn turn = turn_of(session, arguments);
    const std::vector<Curve> curves = curves_of(session, turn);
    const Volume& volume = session.volumes.volume();
    Answer answer;
    std::vector<Answer> summaries;
    for (const Curve& curve : curves) {
        summaries.push_back(summary_of(volume, curve));
    }
    answer.list("surfaces", std::move(summaries)).table(table_of(volume, curves));
    if (!arguments.words.empty()) {
        write_curve(session, curves, arguments.words[0]);
        answer.line("wrote " + arguments.words[0]).data("file", arguments.words[0]);
    }
    return answer.reply();
}

}  // namespace pxpl5::host
