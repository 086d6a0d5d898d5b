#include "host/inspect/model/model_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "host/inspect/model/model_parts.hpp"
#include "host/timing/picture.hpp"

namespace pxpl5::host::inspect {

namespace {

using timing::BuildWork;
using timing::FrameWork;
using timing::RingCount;
using timing::VolumeWork;

/// A step in a few words.
struct StepName {
    std::string operator()(const VolumeWork& volume) const {
        return fmt::format("load {}, {}x{}x{}", volume.name, volume.nx, volume.ny, volume.nz);
    }
    std::string operator()(const BuildWork& build) const {
        std::uint64_t triangles = 0;
        for (const timing::SlabWork& slab : build.slabs) {
            triangles += slab.triangles;
        }
        return fmt::format("build surface {} at {}, {}", build.surface, build.isovalue,
                           counted(triangles, "triangle"));
    }
    std::string operator()(const FrameWork& frame) const {
        std::uint64_t primitives = 0;
        for (const timing::DrawnSlab& slab : frame.drawn) {
            primitives += slab.primitives;
        }
        return fmt::format("frame {}, {}x{}{}{}, {}", frame.frame, frame.width, frame.height,
                           frame.views == 1 ? "" : fmt::format(" x {}", frame.views),
                           frame.samples == 1
                               ? ""
                               : fmt::format(", sample {} of {}", frame.sample + 1, frame.samples),
                           counted(primitives, "primitive"));
    }
};

struct StepKind {
    const char* operator()(const VolumeWork&) const { return "load"; }
    const char* operator()(const BuildWork&) const { return "build"; }
    const char* operator()(const FrameWork&) const { return "frame"; }
};

/// The kind of the node at a place of the ring.
std::string_view kind_at(const timing::Machine& machine, std::uint32_t place) {
    if (place == 0) {
        return "host";
    }
    if (place <= machine.gps) {
        return "GPs";
    }
    return place <= machine.gps + machine.renderers ? "Renderers" : "frame buffers";
}

struct RingSum {
    std::uint64_t packets = 0, words = 0;
};
using RingSums = std::map<std::string, RingSum>;

template <typename Name>
RingSums ring_sums(const ModelledRun& run, const Name& name) {
    RingSums sums;
    for (const RingCount& count : run.time.ring) {
        RingSum& one = sums[name(count)];
        one.packets += count.messages;
        one.words += count.words;
    }
    return sums;
}

RingSums by_kind(const ModelledRun& run) {
    return ring_sums(run, [&](const RingCount& count) {
        return fmt::format("{} -> {}", kind_at(run.machine, count.source),
                           kind_at(run.machine, count.destination));
    });
}

RingSums by_channel(const ModelledRun& run) {
    return ring_sums(
        run, [](const RingCount& count) { return fmt::format("channel {:2}", count.channel); });
}

Table ring_table(const char* key, const char* heading, const RingSums& sums) {
    std::uint64_t all = 0;
    for (const auto& [name, one] : sums) {
        all += one.words;
    }
    Table table{key, {{"name", heading}, {"packets", "packets"}, {"words", "words"}, {"", "%"}}};
    for (const auto& [name, one] : sums) {  // No sum is 0.
        const double share = static_cast<double>(one.words) / static_cast<double>(all);
        table.rows.push_back(
            {name, grouped_cell(one.packets), grouped_cell(one.words), fixed_cell(100 * share, 1)});
    }
    return table;
}

Table steps_table(const ModelledRun& run) {
    Table table{"steps",
                {{"step", "step"},
                 {"kind", ""},
                 {"what", "what"},
                 {"begin_ns", ""},
                 {"end_ns", ""},
                 {"", "begin ms"},
                 {"", "time ms"}},
                {},
                2};
    add_use_columns(table);
    for (const timing::StepTime& step : run.time.steps) {
        const timing::StepWork& work = run.work.steps[step.step];
        table.rows.push_back({step.step, std::visit(StepKind(), work), std::visit(StepName(), work),
                              step.begin, step.end, fixed_cell(ms(step.begin), 3),
                              fixed_cell(ms(step.end - step.begin), 3)});
        add_use(table.rows.back(), step.limit, step.use);
    }
    return table;
}

Table rates_table(const ModelledRun& run) {
    Table table{"frames",
                {{"frame", ""},
                 {"samples", ""},
                 {"", "shown repeatedly"},
                 {"frames_per_s", "frames/s"},
                 {"latency_ns", ""},
                 {"", "latency ms"}}};
    add_use_columns(table);
    const std::vector<timing::Picture> pictures = timing::pictures_of(run.work);
    for (std::size_t i = 0; i < pictures.size(); ++i) {
        const FrameWork& first = *pictures[i].passes.front();
        const timing::Rate& rate = run.rates[i];
        table.rows.push_back(
            {first.frame, first.samples, picture_text("frame", first.frame, first.samples),
             fixed_cell(rate.frames_per_s, 2), rate.latency, fixed_cell(ms(rate.latency), 3)});
        add_use(table.rows.back(), rate.limit, rate.use);
    }
    return table;
}

/// A row per step, with the use of every unit in columns of their own.
Table csv_table(const ModelledRun& run) {
    Table table;
    for (const char* key : {"step", "kind", "begin_ns", "end_ns", "limit"}) {
        table.columns.push_back({key, ""});
    }
    for (const timing::UnitUse& use : run.time.steps.front().use) {
        table.columns.push_back({fmt::format("{} mean", timing::name_of(use.unit)), ""});
        table.columns.push_back({fmt::format("{} busiest", timing::name_of(use.unit)), ""});
    }
    table.columns.push_back({"frames_per_s", ""});
    std::map<std::size_t, double> rates;  // By the last step of a picture.
    for (std::size_t i = 0; const timing::Picture& picture : timing::pictures_of(run.work)) {
        rates[picture.step + picture.passes.size() - 1] = run.rates[i++].frames_per_s;
    }
    for (const timing::StepTime& step : run.time.steps) {
        std::vector<Cell>& row = table.rows.emplace_back();
        row = {step.step, std::visit(StepKind(), run.work.steps[step.step]), step.begin, step.end,
               timing::name_of(step.limit)};
        for (const timing::UnitUse& use : step.use) {
            row.insert(row.end(), {use.mean, use.busiest});
        }
        const auto rate = rates.find(step.step);
        row.emplace_back(rate == rates.end() ? std::nullopt : std::optional(rate->second));
    }
    return table;
}

}  // namespace

ModelledRun modelled(const Topology& plan, timing::RunWork work) {
    ModelledRun run{plan, timing::machine_of(plan), std::move(work), {}, {}};
    run.time = timing::simulate(run.machine, run.work);
    for (const timing::Picture& picture : timing::pictures_of(run.work)) {
        run.rates.push_back(timing::picture_rate(run.machine, picture));
    }
    return run;
}

Answer answer_of(const ModelledRun& run) {
    const Table rates = rates_table(run);
    Answer answer = machine_answer(run.plan, run.work.missing);
    answer.line("").table(steps_table(run));
    if (std::ranges::any_of(run.work.steps, [](const timing::StepWork& step) {
            return std::holds_alternative<VolumeWork>(step);
        })) {
        answer.line(load_note);
    }
    answer.line("").table(rates);
    if (rates.rows.empty()) {
        answer.line("no complete picture");
    }
    return answer.line("")
        .table(ring_table("ring", "words on the ring", by_kind(run)))
        .line("")
        .table(ring_table("channels", "channel", by_channel(run)))
        .data("events", run.time.events)
        .csv_table(csv_table(run));
}

}  // namespace pxpl5::host::inspect
