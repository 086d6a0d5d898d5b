#include "host/inspect/model/model_run.hpp"

#include <fmt/format.h>

#include <map>
#include <utility>

#include "host/inspect/model/model_parts.hpp"
#include "host/inspect/record/message_text.hpp"
#include "host/timing/picture.hpp"

namespace pxpl5::host::inspect {

namespace {

using timing::BuildWork;
using timing::FrameWork;
using timing::RingCount;
using timing::VolumeWork;

constexpr double percent = 100;

std::int64_t number(std::uint64_t n) {
    return static_cast<std::int64_t>(n);
}

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

/// What kind of node has the place on the ring.
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

std::string ring_text(const std::string& what, const RingSums& sums) {
    std::uint64_t all = 0;
    for (const auto& [name, one] : sums) {
        all += one.words;
    }
    std::vector<TableRow> rows;
    for (const auto& [name, one] : sums) {  // Nothing is there that is 0.
        rows.push_back({name, grouped(one.packets), grouped(one.words),
                        fmt::format("{:.1f}", percent * static_cast<double>(one.words) /
                                                  static_cast<double>(all))});
    }
    return text_table({what, "packets", "words", "%"}, rows);
}

std::vector<Fields> ring_fields(const RingSums& sums) {
    std::vector<Fields> rows;
    for (const auto& [name, one] : sums) {
        rows.push_back(
            {{"name", name}, {"packets", number(one.packets)}, {"words", number(one.words)}});
    }
    return rows;
}

std::string steps_text(const ModelledRun& run) {
    TableRow heading{"step", "what", "begin ms", "time ms"};
    add_use_headings(heading);
    std::vector<TableRow> rows;
    for (const timing::StepTime& step : run.time.steps) {
        rows.push_back({fmt::format("{}", step.step),
                        std::visit(StepName(), run.work.steps[step.step]),
                        fmt::format("{:.3f}", ms(step.begin)),
                        fmt::format("{:.3f}", ms(step.end - step.begin))});
        add_use(rows.back(), step.limit, step.use);
    }
    return text_table(heading, rows, 2);
}

std::string rates_text(const ModelledRun& run) {
    const std::vector<timing::Picture> pictures = timing::pictures_of(run.work);
    if (pictures.empty()) {
        return "no whole picture\n";
    }
    TableRow heading{"shown over and over", "frames/s", "latency ms"};
    add_use_headings(heading);
    std::vector<TableRow> rows;
    for (std::size_t i = 0; i < pictures.size(); ++i) {
        const FrameWork& first = *pictures[i].passes.front();
        rows.push_back({picture_text("frame", first.frame, first.samples),
                        fmt::format("{:.2f}", run.rates[i].frames_per_s),
                        fmt::format("{:.3f}", ms(run.rates[i].latency))});
        add_use(rows.back(), run.rates[i].limit, run.rates[i].use);
    }
    return text_table(heading, rows);
}

std::vector<Fields> step_fields(const ModelledRun& run) {
    std::vector<Fields> steps;
    for (const timing::StepTime& step : run.time.steps) {
        const timing::StepWork& work = run.work.steps[step.step];
        steps.push_back({{"step", number(step.step)},
                         {"kind", std::string(std::visit(StepKind(), work))},
                         {"what", std::visit(StepName(), work)},
                         {"begin_ns", step.begin},
                         {"end_ns", step.end},
                         {"limit", std::string(timing::name_of(step.limit))},
                         {"use", use_fields(step.use)}});
    }
    return steps;
}

std::vector<Fields> rate_fields(const ModelledRun& run) {
    std::vector<Fields> rows;
    const std::vector<timing::Picture> pictures = timing::pictures_of(run.work);
    for (std::size_t i = 0; i < pictures.size(); ++i) {
        const FrameWork& first = *pictures[i].passes.front();
        rows.push_back({{"frame", std::int64_t{first.frame}},
                        {"samples", std::int64_t{first.samples}},
                        {"frames_per_s", run.rates[i].frames_per_s},
                        {"latency_ns", run.rates[i].latency},
                        {"limit", std::string(timing::name_of(run.rates[i].limit))},
                        {"use", use_fields(run.rates[i].use)}});
    }
    return rows;
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

std::string to_text(const ModelledRun& run) {
    return "machine: " + machine_text(run.plan) + "\n" + missing_text(run.work.missing) +
           "%: of the time, how long the busiest of its kind was busy\n\n" + steps_text(run) +
           "\n" + rates_text(run) + "\n" + ring_text("words on the ring", by_kind(run)) + "\n" +
           ring_text("channel", by_channel(run));
}

Fields to_fields(const ModelledRun& run) {
    return {{"machine", machine_fields(run.plan)},
            {"steps", step_fields(run)},
            {"frames", rate_fields(run)},
            {"ring", ring_fields(by_kind(run))},
            {"channels", ring_fields(by_channel(run))},
            {"events", number(run.time.events)},
            {"missing", missing_fields(run.work.missing)}};
}

std::string to_csv(const ModelledRun& run) {
    std::string text = "step,kind,begin_ns,end_ns,limit";
    for (const timing::UnitUse& use : run.time.steps.front().use) {
        text += fmt::format(",{} mean,{} busiest", timing::name_of(use.unit),
                            timing::name_of(use.unit));
    }
    text += ",frames_per_s\n";
    std::map<std::size_t, double> rates;  // By a picture's last step.
    for (std::size_t i = 0; const timing::Picture& picture : timing::pictures_of(run.work)) {
        rates[picture.step + picture.passes.size() - 1] = run.rates[i++].frames_per_s;
    }
    for (const timing::StepTime& step : run.time.steps) {
        const timing::StepWork& work = run.work.steps[step.step];
        text += fmt::format("{},{},{},{},{}", step.step, std::visit(StepKind(), work), step.begin,
                            step.end, timing::name_of(step.limit));
        for (const timing::UnitUse& use : step.use) {
            text += fmt::format(",{},{}", use.mean, use.busiest);
        }
        text += rates.contains(step.step) ? fmt::format(",{}\n", rates[step.step]) : ",\n";
    }
    return text;
}

}  // namespace pxpl5::host::inspect
