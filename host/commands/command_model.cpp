// The command `model`: the modelled time of the scene on another machine.
#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "host/commands/command_handlers.hpp"
#include "host/inspect/model/model_parts.hpp"
#include "host/machine/modelled_topology.hpp"
#include "host/machine/timing_section.hpp"
#include "host/session/live_work.hpp"
#include "host/timing/picture.hpp"

namespace pxpl5::host {

using inspect::ms;
using inspect::use_fields;

namespace {

constexpr const char* usual_machine = "paper-1993";

double percent(double share) {
    return share * 100;
}

std::string limit_text(const std::vector<timing::UnitUse>& use, timing::Unit limit) {
    const timing::UnitUse& most = timing::busiest_of(use);
    return fmt::format("limit {}, {}{:.0f} % busy", timing::name_of(limit),
                       limit == timing::Unit::waiting ? fmt::format("{} ", name_of(most.unit)) : "",
                       percent(most.busiest));
}

/// One line for each kind of unit.
std::string use_text(const std::vector<timing::UnitUse>& use) {
    std::string text;
    for (const timing::UnitUse& unit : use) {
        text += fmt::format("\n  {:<12} {:5.1f} % busy on average, number {} {:5.1f} %",
                            timing::name_of(unit.unit), percent(unit.mean), unit.index,
                            percent(unit.busiest));
    }
    return text;
}

Fields step_fields(const timing::StepTime& step) {
    return {{"ms", ms(step.end - step.begin)},
            {"limit", std::string(timing::name_of(step.limit))},
            {"use", use_fields(step.use)}};
}

/// Describes a run step by step.
class Telling {
  public:
    Telling(const Session& session, const timing::Machine& machine, const timing::RunWork& run)
        : session_(session), machine_(machine), run_(run), time_(simulate(machine, run)) {}

    Reply told(const std::string& name) {
        reply_.text = fmt::format("{}, modelled: {}, {}, {}", name, counted(machine_.gps, "GP"),
                                  counted(machine_.renderers, "Renderer"),
                                  counted(machine_.frame_buffers, "frame buffer"));
        reply_.fields = {{"machine", name},
                         {"gps", std::int64_t{machine_.gps}},
                         {"renderers", std::int64_t{machine_.renderers}},
                         {"frame_buffers", std::int64_t{machine_.frame_buffers}}};
        std::vector<Fields> builds;
        for (const timing::StepTime& step : time_.steps) {
            if (const auto* build = std::get_if<timing::BuildWork>(&run_.steps[step.step])) {
                builds.push_back(tell_build(*build, step));
            } else if (std::holds_alternative<timing::VolumeWork>(run_.steps[step.step])) {
                tell_load(step);
            }
        }
        reply_.fields.push_back({"surfaces", builds});
        tell_frame();
        return std::move(reply_);
    }

  private:
    void tell_load(const timing::StepTime& step) {
        reply_.text += fmt::format("\nload: {:.0f} ms; {}\n{}", ms(step.end - step.begin),
                                   limit_text(step.use, step.limit), inspect::load_note);
        reply_.fields.push_back({"load", step_fields(step)});
    }

    Fields tell_build(const timing::BuildWork& build, const timing::StepTime& step) {
        const auto surface =
            std::ranges::find(session_.scene.surfaces, build.surface, &Surface::id);
        std::uint64_t triangles = 0;
        for (const timing::SlabWork& slab : build.slabs) {
            triangles += slab.triangles;
        }
        reply_.text +=
            fmt::format("\nsurface {}: {} triangles built in {:.1f} ms; {}", surface->name,
                        triangles, ms(step.end - step.begin), limit_text(step.use, step.limit));
        Fields fields = {{"name", surface->name},
                         {"triangles", static_cast<std::int64_t>(triangles)}};
        std::ranges::copy(step_fields(step), std::back_inserter(fields));
        return fields;
    }

    void tell_frame() {
        const timing::Picture picture = timing::pictures_of(run_).back();
        const timing::FrameWork& frame = *picture.passes.front();
        const timing::Rate rate = timing::picture_rate(machine_, picture);
        std::uint64_t primitives = 0;
        for (const timing::DrawnSlab& slab : frame.drawn) {
            primitives += slab.primitives;
        }
        reply_.text += fmt::format("\nframe: {} primitives, {} x {} pixels, ", primitives,
                                   frame.width, frame.height);
        reply_.text += fmt::format(
            "{}{:.1f} a second, each shown {:.1f} ms after it was asked for; {}",
            frame.samples == 1 ? "" : fmt::format("{} samples per pixel, ", frame.samples),
            rate.frames_per_s, ms(rate.latency), limit_text(rate.use, rate.limit));
        reply_.text += use_text(rate.use);
        reply_.fields.push_back(
            {"frame", Fields{{"primitives", static_cast<std::int64_t>(primitives)},
                             {"samples", std::int64_t{frame.samples}},
                             {"frames_per_s", rate.frames_per_s},
                             {"latency_ms", ms(rate.latency)},
                             {"limit", std::string(timing::name_of(rate.limit))},
                             {"use", use_fields(rate.use)}}});
    }

    const Session& session_;
    const timing::Machine& machine_;
    const timing::RunWork& run_;
    timing::RunTime time_;
    Reply reply_;
};

}  // namespace

std::vector<Parameter> model_options() {
    std::vector<Parameter> options;
    for (const std::string_view name : timing_names()) {
        options.push_back({name, "VALUE", "parameter of the timing model"});
    }
    for (const std::string_view count : {"gp.count", "renderer.count", "frame_buffer.count"}) {
        options.push_back({count, "N", "number of nodes"});
    }
    return options;
}

Reply run_model(Session& session, const Arguments& arguments) {
    const std::string name = arguments.words.empty() ? usual_machine : arguments.words[0];
    std::vector<std::string> overrides;
    for (const auto& [key, value] : arguments.options) {
        overrides.push_back(key + "=" + value);
    }
    // Before anything is drawn: a word that is wrong costs nothing.
    const timing::Machine machine = timing::machine_of(load_modelled_topology(name, overrides));
    const timing::RunWork run = live_work(session);
    return Telling(session, machine, run).told(name);
}

}  // namespace pxpl5::host
