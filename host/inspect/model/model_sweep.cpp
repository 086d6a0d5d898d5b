#include "host/inspect/model/model_sweep.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <utility>

#include "host/base/error.hpp"
#include "host/chart/plot.hpp"
#include "host/inspect/model/model_parts.hpp"
#include "host/timing/picture.hpp"

namespace pxpl5::host::inspect {

namespace {

using timing::Ns;
using timing::SweptMachine;

/// A time in ms in the text and in ns for programs.
Cell time_cell(const std::optional<Ns>& time) {
    return {field_value(time), time ? fmt::format("{:.3f}", ms(*time)) : "-"};
}

double number_of(const timing::SweptKey& key, const std::string& text) {
    double number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(number)) {
        throw RequestError(
            ExitCode::usage,
            fmt::format("--plot: {} is '{}', but an axis needs numbers", key.key, text));
    }
    return number;
}

/// Logarithmic if the largest value is at least 8 times the smallest value.
PlotScale scale_of(const timing::SweptKey& key) {
    constexpr double octaves_from = 8;
    double least = number_of(key, key.values.front()), most = least;
    for (const std::string& text : key.values) {
        least = std::min(least, number_of(key, text));
        most = std::max(most, number_of(key, text));
    }
    return least > 0 && most >= octaves_from * least ? PlotScale::log2 : PlotScale::linear;
}

/// A line for each value of the second key.
template <typename Value>
LinePlot lines_of(const ModelledSweep& sweep, const std::string& y_label, const Value& y) {
    const timing::SweptKey& key = sweep.keys.front();
    LinePlot plot{
        fmt::format("{} on {}", picture_text("Frame", sweep.frame, sweep.samples), sweep.plan.name),
        "",
        {key.key, scale_of(key)},
        {y_label},
        {}};
    const bool several = sweep.keys.size() > 1;
    const std::size_t lines = several ? sweep.keys[1].values.size() : 1;
    for (std::size_t line = 0; line < lines; ++line) {
        PlotLine& one = plot.lines.emplace_back();
        one.name = several ? sweep.keys[1].key + " " + sweep.keys[1].values[line] : "";
        one.color = line;
        for (std::size_t n = line; n < sweep.machines.size(); n += lines) {
            const SweptMachine& machine = sweep.machines[n];
            one.points.push_back({number_of(key, machine.values.front()), y(machine)});
        }
    }
    return plot;
}

}  // namespace

ModelledSweep swept(const Topology& plan, std::vector<timing::SweptKey> keys,
                    const timing::RunWork& work) {
    const std::vector<timing::Picture> pictures = timing::pictures_of(work);
    if (pictures.empty()) {
        throw RequestError(ExitCode::bad_data,
                           "--sweep times a frame, and none could be counted" +
                               (work.missing.empty() ? std::string() : ": " + work.missing.back()));
    }
    const timing::Picture& last = pictures.back();
    ModelledSweep sweep{plan,
                        std::move(keys),
                        last.passes.front()->frame,
                        last.passes.front()->samples,
                        work.missing,
                        {}};
    sweep.machines = timing::sweep(plan, sweep.keys, work, last.step);
    return sweep;
}

Answer answer_of(const ModelledSweep& sweep) {
    Table table{"machines", {{"set", ""}}, {}, 0};
    Table csv;  // As the table, with a column for each key that is swept.
    for (const timing::SweptKey& key : sweep.keys) {
        table.columns.push_back({"", key.key});
        csv.columns.push_back({key.key, ""});
    }
    const Column values[] = {{"load_ns", "load ms"},
                             {"build_ns", "build ms"},
                             {"build_limit", "limit of build"},
                             {"frames_per_s", "frames/s"},
                             {"latency_ns", "latency ms"}};
    table.columns.insert(table.columns.end(), std::begin(values), std::end(values));
    csv.columns.insert(csv.columns.end(), std::begin(values), std::end(values));
    add_use_columns(table);
    csv.columns.push_back({"limit", ""});
    for (const SweptMachine& machine : sweep.machines) {
        Fields set;
        std::vector<Cell> row;
        for (std::size_t k = 0; k < sweep.keys.size(); ++k) {
            set.push_back({sweep.keys[k].key, machine.values[k]});
            row.emplace_back(machine.values[k]);
        }
        row.insert(row.end(),
                   {time_cell(machine.load), time_cell(machine.build),
                    machine.build ? Cell(timing::name_of(machine.build_limit)) : Cell(nullptr),
                    fixed_cell(machine.rate.frames_per_s, 2), time_cell(machine.rate.latency)});
        csv.rows.push_back(row);
        csv.rows.back().emplace_back(timing::name_of(machine.rate.limit));
        add_use(row, machine.rate.limit, machine.rate.use);
        row.insert(row.begin(), Cell(set));
        table.rows.push_back(std::move(row));
    }
    const bool has_load = std::ranges::any_of(
        sweep.machines, [](const SweptMachine& machine) { return machine.load.has_value(); });
    Answer answer = machine_answer(sweep.plan, sweep.missing);
    if (has_load) {
        answer.line(load_note);
    }
    return answer
        .line(picture_text("frame", sweep.frame, sweep.samples) +
              ", shown repeatedly; load and build: time for the contents of this frame")
        .data("frame", sweep.frame)
        .data("samples", sweep.samples)
        .line("")
        .table(std::move(table))
        .csv_table(std::move(csv));
}

void check_axis(const timing::SweptKey& key) {
    for (const std::string& text : key.values) {
        number_of(key, text);
    }
}

Chart plot_of(const ModelledSweep& sweep) {
    std::vector<Plot> plots;
    plots.emplace_back(
        lines_of(sweep, "frames/s", [](const SweptMachine& m) { return m.rate.frames_per_s; }));
    if (sweep.machines.front().build) {
        plots.emplace_back(
            lines_of(sweep, "ms to build", [](const SweptMachine& m) { return ms(*m.build); }));
    }
    return chart_of(plots, plots.size());
}

}  // namespace pxpl5::host::inspect
