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

FieldValue value_of(const std::optional<Ns>& time) {
    return time ? FieldValue(*time) : FieldValue(nullptr);
}

std::string cell_of(const std::optional<Ns>& time) {
    return time ? fmt::format("{:.3f}", ms(*time)) : "-";
}

double number_of(const timing::SweptKey& key, const std::string& text) {
    double number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(number)) {
        throw RequestError(
            ExitCode::usage,
            fmt::format("--plot: {} is '{}', must be a number to be an axis", key.key, text));
    }
    return number;
}

/// Octaves, where the values reach over so many times their least.
PlotScale scale_of(const timing::SweptKey& key) {
    constexpr double octaves_from = 8;
    double least = number_of(key, key.values.front()), most = least;
    for (const std::string& text : key.values) {
        least = std::min(least, number_of(key, text));
        most = std::max(most, number_of(key, text));
    }
    return least > 0 && most >= octaves_from * least ? PlotScale::log2 : PlotScale::linear;
}

/// A line for each value of the second key. y(machine) may be nothing.
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

std::string to_text(const ModelledSweep& sweep) {
    TableRow heading;
    for (const timing::SweptKey& key : sweep.keys) {
        heading.push_back(key.key);
    }
    heading.insert(heading.end(),
                   {"load ms", "build ms", "build's limit", "frames/s", "latency ms"});
    add_use_headings(heading);
    std::vector<TableRow> rows;
    for (const SweptMachine& machine : sweep.machines) {
        TableRow& row = rows.emplace_back(machine.values);
        row.insert(row.end(),
                   {cell_of(machine.load), cell_of(machine.build),
                    machine.build ? std::string(timing::name_of(machine.build_limit)) : "-",
                    fmt::format("{:.2f}", machine.rate.frames_per_s),
                    fmt::format("{:.3f}", ms(machine.rate.latency))});
        add_use(row, machine.rate.limit, machine.rate.use);
    }
    return "machine: " + machine_text(sweep.plan) + "\n" + missing_text(sweep.missing) +
           fmt::format(
               "{}, shown over and over; load and build: of what it shows\n"
               "%: of the time, how long the busiest of its kind was busy\n\n",
               picture_text("frame", sweep.frame, sweep.samples)) +
           text_table(heading, rows, 0);
}

Fields to_fields(const ModelledSweep& sweep) {
    std::vector<Fields> machines;
    for (const SweptMachine& machine : sweep.machines) {
        Fields set;
        for (std::size_t k = 0; k < sweep.keys.size(); ++k) {
            set.push_back({sweep.keys[k].key, machine.values[k]});
        }
        machines.push_back(
            {{"set", set},
             {"load_ns", value_of(machine.load)},
             {"build_ns", value_of(machine.build)},
             {"build_limit", machine.build
                                 ? FieldValue(std::string(timing::name_of(machine.build_limit)))
                                 : FieldValue(nullptr)},
             {"frames_per_s", machine.rate.frames_per_s},
             {"latency_ns", machine.rate.latency},
             {"limit", std::string(timing::name_of(machine.rate.limit))},
             {"use", use_fields(machine.rate.use)}});
    }
    return {{"machine", machine_fields(sweep.plan)},
            {"frame", std::int64_t{sweep.frame}},
            {"samples", std::int64_t{sweep.samples}},
            {"machines", machines},
            {"missing", missing_fields(sweep.missing)}};
}

std::string to_csv(const ModelledSweep& sweep) {
    std::string text;
    for (const timing::SweptKey& key : sweep.keys) {
        text += key.key + ",";
    }
    text += "load_ns,build_ns,build_limit,frames_per_s,latency_ns,limit\n";
    const auto put = [&](const std::optional<Ns>& time) {
        text += time ? fmt::format("{},", *time) : ",";
    };
    for (const SweptMachine& machine : sweep.machines) {
        for (const std::string& value : machine.values) {
            text += value + ",";
        }
        put(machine.load);
        put(machine.build);
        text += fmt::format(
            "{},{},{},{}\n", machine.build ? timing::name_of(machine.build_limit) : "",
            machine.rate.frames_per_s, machine.rate.latency, timing::name_of(machine.rate.limit));
    }
    return text;
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
