#include "host/inspect/model/model_cluster.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "host/base/error.hpp"
#include "host/inspect/model/model_parts.hpp"
#include "host/timing/sweep.hpp"

namespace pxpl5::host::inspect {

namespace {

constexpr std::size_t most_computers = 256;
constexpr double us_per_ms = 1e3, bytes_per_mb = 1e6;

std::vector<std::size_t> counts_of(const std::string& text) {
    std::vector<std::size_t> counts;
    for (const std::string& value : timing::parse_sweep("computers=" + text).values) {
        std::size_t count = 0;
        const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), count);
        if (error != std::errc{} || end != value.data() + value.size() || count < 1 ||
            count > most_computers) {
            throw RequestError(ExitCode::usage,
                               fmt::format("--cluster {}: '{}' must be a number of computers, 1 to "
                                           "{}",
                                           text, value, most_computers));
        }
        counts.push_back(count);
    }
    return counts;
}

/// The picture, the newest build of a surface before it, and the volume.
timing::ClusterWork last_picture(const timing::RunWork& work) {
    const std::vector<timing::Picture> pictures = timing::pictures_of(work);
    if (pictures.empty()) {
        throw RequestError(ExitCode::bad_data,
                           "--cluster times a frame, and none could be counted" +
                               (work.missing.empty() ? std::string() : ": " + work.missing.back()));
    }
    timing::ClusterWork last{.picture = pictures.back()};
    for (std::size_t step = 0; step < last.picture.step; ++step) {
        if (const auto* volume = std::get_if<timing::VolumeWork>(&work.steps[step])) {
            last.volume = volume;
            last.build = nullptr;
        } else if (const auto* build = std::get_if<timing::BuildWork>(&work.steps[step])) {
            last.build = build;
        }
    }
    return last;
}

Table parameter_table(const timing::Cluster& cluster) {
    Table table{"parameters",
                {{"name", "parameter"},
                 {"unit", "unit"},
                 {"value", "value"},
                 {"least", "least"},
                 {"most", "most"},
                 {"usual", "usual"},
                 {"source", "source of the usual value"}},
                {},
                2};
    const auto number = [](double value) { return Cell(value, fmt::format("{:g}", value)); };
    for (const timing::ClusterRow& row : timing::cluster_rows()) {
        table.rows.push_back({row.name, row.unit, number(cluster.*row.value), number(row.least),
                              number(row.most), number(row.usual), row.source});
    }
    return table;
}

std::vector<Fields> use_fields(const std::vector<timing::ClusterUse>& busiest) {
    std::vector<Fields> list;
    for (const timing::ClusterUse& use : busiest) {
        list.push_back({{"unit", std::string(timing::name_of(use.unit))},
                        {"computer", static_cast<std::int64_t>(use.computer)},
                        {"us", use.us}});
    }
    return list;
}

/// CSV has no lists.
Table point_table(const ModelledCluster& model, bool has_use) {
    Table table{"computers",
                {{"computers", "computers"},
                 {"frames_per_s", "frames/s"},
                 {"frame_ms", "ms/frame"},
                 {"limit", "limit"},
                 {"latency_ms", "one at a time, ms"},
                 {"isovalue_ms", "isovalue to picture, ms"},
                 {"isovalue_limit", "mostly"},
                 {"network_mb", "MB/frame between computers"},
                 {"load_mb", "MB of slices"},
                 {"load_ms", "ms"},
                 {"lever", "best change"},
                 {"lever_gain_percent", "gain, %"},
                 {"use", ""}},
                {},
                1};
    table.columns.resize(table.columns.size() - (has_use ? 0 : 1));
    for (const ModelledComputers& point : model.points) {
        const timing::ClusterTime& time = point.time;
        const bool has_isovalue = time.isovalue_us.has_value();
        table.rows.push_back(
            {point.computers, fixed_cell(time.frames_per_s, 1), fixed_cell(time.frame_ms(), 2),
             timing::name_of(time.limit.unit), fixed_cell(time.latency_us / us_per_ms, 2),
             has_isovalue ? fixed_cell(*time.isovalue_us / us_per_ms, 2) : Cell(nullptr),
             has_isovalue ? Cell(timing::name_of(time.isovalue_limit)) : Cell(nullptr),
             fixed_cell(time.network_bytes / bytes_per_mb, 3),
             fixed_cell(time.load_network_bytes / bytes_per_mb, 2),
             fixed_cell(time.load_us / us_per_ms, 1), point.lever.change,
             fixed_cell(100 * point.lever.gain, 0)});
        if (has_use) {
            table.rows.back().emplace_back(use_fields(time.busiest));
        }
    }
    return table;
}

Table crossing_table(const ModelledCluster& model) {
    const auto name = [&](std::size_t computer) {
        return model.cluster.host_apart && computer + 1 == model.points.back().plan.computers
                   ? std::string("the host's")
                   : fmt::format("n{}", computer + 1);
    };
    Table table{"crossings",
                {{"kind", "between computers"},
                 {"from", "from"},
                 {"to", "to"},
                 {"messages", "messages"},
                 {"bytes", "bytes"}},
                {},
                3};
    for (const timing::Crossing& one : model.crossings) {
        table.rows.push_back({one.name, name(one.from), name(one.to),
                              grouped_cell(static_cast<std::uint64_t>(one.messages)),
                              grouped_cell(static_cast<std::uint64_t>(one.bytes))});
    }
    return table;
}

}  // namespace

ModelledCluster modelled_cluster(const Topology& topology, const timing::Cluster& cluster,
                                 const std::string& computers, const timing::RunWork& work) {
    const std::vector<std::size_t> counts = counts_of(computers);
    const timing::ClusterWork last = last_picture(work);
    const timing::FrameWork& first = *last.picture.passes.front();
    ModelledCluster model{topology, cluster, first.frame, first.samples, work.missing, {}, {}};
    for (const std::size_t count : counts) {
        const timing::ClusterPlan plan = timing::cluster_plan(topology, cluster, count);
        model.points.push_back({count, plan, timing::cluster_time(cluster, plan, last),
                                timing::best_lever(cluster, plan, last, false)});
    }
    model.crossings = timing::crossings(cluster, model.points.back().plan, last);
    return model;
}

Answer answer_of(const ModelledCluster& model) {
    const std::string text = fmt::format(
        "{} and {}, placement {}; the host {}", counted(model.topology.gp.count, "GP"),
        counted(model.topology.renderer.count, "Renderer"),
        enum_names<Placement>[static_cast<std::size_t>(model.topology.cluster.placement)],
        model.cluster.host_apart ? "has a computer of its own" : "is on n1");
    return Answer()
        .line("machine: " + text)
        .data("machine", text)
        .data("gps", model.topology.gp.count)
        .data("renderers", model.topology.renderer.count)
        .data("host_apart", model.cluster.host_apart)
        .sentences("missing", "text", "Not counted: ", model.missing)
        .line(picture_text("frame", model.frame, model.samples) + ", shown repeatedly")
        .data("frame", model.frame)
        .data("samples", model.samples)
        .line("")
        .table(parameter_table(model.cluster))
        .line("")
        .table(point_table(model, true))
        .line("")
        .line(fmt::format("a frame, and the slices of the volume, with {}:",
                          counted(model.points.back().computers, "computer")))
        .table(crossing_table(model))
        .csv_table(point_table(model, false));
}

}  // namespace pxpl5::host::inspect
