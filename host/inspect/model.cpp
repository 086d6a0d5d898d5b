#include "host/inspect/model.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "host/error.hpp"
#include "host/inspect/find_run.hpp"
#include "host/inspect/model_run.hpp"
#include "host/inspect/model_sweep.hpp"
#include "host/inspect/recorded_work.hpp"
#include "host/inspect/text_output.hpp"

namespace pxpl5::host::inspect {

namespace {

/// Throws RequestError (usage) that names the frames there are if none of these is there.
void check_frames(const RecordedRun& run, const std::vector<Range>& ranges) {
    const std::vector<std::uint32_t> frames = run.frames();
    for (const Range& range : ranges) {
        if (std::ranges::none_of(frames, [&](std::uint32_t n) { return range.contains(n); })) {
            run.frame(range.from);  // Says which frames there are.
        }
    }
}

timing::RunWork work_of(const ModelOptions& options) {
    const std::vector<Range> frames = parse_selection(options.selection).frames;
    const RecordedRun run = open_run(options.run);
    check_frames(run, frames);
    timing::RunWork work = recorded_work(run, frames);
    if (work.steps.empty()) {
        throw RequestError(ExitCode::bad_data,
                           work.missing.empty()
                               ? "the run has loaded no volume, built no surface and drawn nothing"
                               : fmt::format("nothing of the run could be counted: {}",
                                             fmt::join(work.missing, "; ")));
    }
    return work;
}

template <typename Result>
void put(const ModelOptions& options, const Result& result) {
    if (!options.csv.empty()) {
        TextOutput csv(options.csv);
        csv.put(to_csv(result));
        csv.finish();
    }
    TextOutput output(options.output);
    output.put(options.json ? json_text(to_fields(result)) + "\n" : to_text(result));
    output.finish();
}

void put_plot(const ModelOptions& options, const ModelledSweep& sweep) {
    if (!options.plot.empty()) {
        TextOutput plot(options.plot);
        plot.put(plot_of(sweep));
        plot.finish();
    }
}

}  // namespace

int run_model(const ModelOptions& options) {
    // What is asked wrongly is said before anything is read.
    const Topology plan = load_topology(options.topology, options.overrides);
    std::vector<timing::SweptKey> keys;
    for (const std::string& text : options.sweeps) {
        keys.push_back(timing::parse_sweep(text));
        Topology changed = plan;
        apply_override(changed, keys.back().key + "=" + keys.back().values.front());
    }
    if (keys.empty() && !options.plot.empty()) {
        throw RequestError(ExitCode::usage, "--plot needs --sweep: one machine is no curve");
    }
    timing::RunWork work = work_of(options);
    if (keys.empty()) {
        put(options, modelled(plan, std::move(work)));
    } else {
        const ModelledSweep sweep = swept(plan, std::move(keys), work);
        put_plot(options, sweep);
        put(options, sweep);
    }
    return 0;
}

}  // namespace pxpl5::host::inspect
