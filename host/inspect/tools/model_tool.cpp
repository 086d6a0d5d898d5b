// pxpl5 model: the time of a recorded run on the machine of 1993, or on another.

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <optional>
#include <utility>

#include "host/base/answer.hpp"
#include "host/base/error.hpp"
#include "host/base/text_output.hpp"
#include "host/inspect/model/model_cluster.hpp"
#include "host/inspect/model/model_run.hpp"
#include "host/inspect/model/model_sweep.hpp"
#include "host/inspect/model/recorded_work.hpp"
#include "host/inspect/record/find_run.hpp"
#include "host/inspect/tools/tools.hpp"
#include "host/machine/modelled_topology.hpp"
#include "host/session/pictures/write_picture.hpp"

namespace pxpl5::host::inspect {

namespace {

constexpr const char* default_topology = "paper-1993";

/// Throws RequestError (usage) for options of --cluster without it, and the reverse.
void check_cluster(const ModelOptions& options) {
    const bool has_cluster = !options.cluster.empty();
    if (has_cluster && (!options.sweeps.empty() || !options.plot.empty())) {
        throw RequestError(ExitCode::usage,
                           "--sweep and --plot model the machine of 1993, --cluster several "
                           "computers of today: give only one. `report --scaling --cluster "
                           "--picture FILE` draws curves");
    }
    if (!has_cluster && !options.computers.is_empty()) {
        throw RequestError(ExitCode::usage,
                           "--link, --link-mbit, --cores, --cluster-set and --host-apart go with "
                           "--cluster");
    }
}

/// Throws RequestError (usage) that lists the recorded frames if a range has none of them.
void check_frames(const RecordedRun& run, const std::vector<Range>& ranges) {
    const std::vector<std::uint32_t> frames = run.frames();
    for (const Range& range : ranges) {
        if (std::ranges::none_of(frames, [&](std::uint32_t n) { return range.contains(n); })) {
            run.frame(range.from);  // Lists the recorded frames.
        }
    }
}

timing::RunWork work_of(const ModelOptions& options, const RecordedRun& run) {
    const std::vector<Range> frames = parse_selection(options.selection).frames;
    check_frames(run, frames);
    timing::RunWork work = recorded_work(run, frames);
    if (work.steps.empty()) {
        throw RequestError(ExitCode::bad_data,
                           work.missing.empty()
                               ? "the run loaded no volume, built no surface and drew no frame"
                               : fmt::format("no part of the run could be counted: {}",
                                             fmt::join(work.missing, "; ")));
    }
    return work;
}

/// A text, and the file that it goes to.
struct Output {
    std::string path, text;
};

std::vector<Output> outputs_of(const ModelOptions& options, const Answer& answer) {
    std::vector<Output> outputs;
    if (!options.csv.empty()) {
        outputs.push_back({options.csv, rendered(answer, Format::csv)});
    }
    outputs.push_back(
        {options.output, rendered(answer, options.json ? Format::json : Format::text)});
    return outputs;
}

/// Writes all outputs, then throws the first error.
void put(const std::vector<Output>& outputs) {
    std::exception_ptr failed;
    for (const auto& [path, text] : outputs) {
        try {
            TextOutput output(path);
            output.put(text);
            output.finish();
        } catch (...) {
            failed = failed ? failed : std::current_exception();
        }
    }
    if (failed) {
        std::rethrow_exception(failed);
    }
}

/// The keys of --sweep; throws RequestError (usage) if they or their values cannot be swept.
std::vector<timing::SweptKey> keys_of(const ModelOptions& options, const Topology& plan) {
    std::vector<timing::SweptKey> keys;
    for (const std::string& text : options.sweeps) {
        keys.push_back(timing::parse_sweep(text));
    }
    if (!keys.empty()) {
        timing::machines_of(plan, keys);
    }
    if (!options.plot.empty()) {
        if (keys.empty()) {
            throw RequestError(ExitCode::usage,
                               "--plot needs --sweep: a curve needs several machines");
        }
        check_picture_suffix("--plot", options.plot);
        check_axis(keys.front());
    }
    return keys;
}

/// The run on several computers. Without --topology, the machine has the nodes of the run.
int run_cluster(const ModelOptions& options) {
    std::vector<std::string> overrides = options.overrides;
    const timing::Cluster cluster = timing::cluster_of(options.computers);
    const std::string topology = options.topology.value_or(default_topology);
    load_modelled_topology(topology, overrides);  // Refuses wrong options.
    const RecordedRun run = open_run(options.run);
    if (!options.topology) {
        overrides.insert(overrides.begin(),
                         {fmt::format("gp.count={}", run.gp_count()),
                          fmt::format("renderer.count={}", run.renderer_count())});
    }
    const Topology plan = load_modelled_topology(topology, overrides);
    put(outputs_of(options, answer_of(modelled_cluster(plan, cluster, options.cluster,
                                                       work_of(options, run)))));
    return 0;
}

}  // namespace

int run_model(const ModelOptions& options) {
    // Wrong options are refused before anything is read.
    check_cluster(options);
    if (!options.cluster.empty()) {
        return run_cluster(options);
    }
    const Topology plan =
        load_modelled_topology(options.topology.value_or(default_topology), options.overrides);
    std::vector<timing::SweptKey> keys = keys_of(options, plan);
    timing::RunWork work = work_of(options, open_run(options.run));
    // Existing files stay unchanged until all results are computed.
    std::vector<Output> outputs;
    std::optional<Chart> plot;
    if (keys.empty()) {
        outputs = outputs_of(options, answer_of(modelled(plan, std::move(work))));
    } else {
        const ModelledSweep sweep = swept(plan, std::move(keys), work);
        outputs = outputs_of(options, answer_of(sweep));
        if (!options.plot.empty()) {
            plot = plot_of(sweep);
        }
    }
    put(outputs);
    if (plot) {
        write_chart(options.plot, *plot, "pxpl5 model");
    }
    return 0;
}

}  // namespace pxpl5::host::inspect
