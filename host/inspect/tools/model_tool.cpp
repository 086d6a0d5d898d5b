// pxpl5 model: the time of a recorded run on the machine of 1993, or on another.

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <optional>
#include <utility>

#include "host/base/answer.hpp"
#include "host/base/error.hpp"
#include "host/base/text_output.hpp"
#include "host/inspect/model/model_run.hpp"
#include "host/inspect/model/model_sweep.hpp"
#include "host/inspect/model/recorded_work.hpp"
#include "host/inspect/record/find_run.hpp"
#include "host/inspect/tools/tools.hpp"
#include "host/machine/modelled_topology.hpp"
#include "host/session/pictures/write_picture.hpp"

namespace pxpl5::host::inspect {

namespace {

/// Throws RequestError (usage) that lists the recorded frames if a range has none of them.
void check_frames(const RecordedRun& run, const std::vector<Range>& ranges) {
    const std::vector<std::uint32_t> frames = run.frames();
    for (const Range& range : ranges) {
        if (std::ranges::none_of(frames, [&](std::uint32_t n) { return range.contains(n); })) {
            run.frame(range.from);  // Lists the recorded frames.
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

}  // namespace

int run_model(const ModelOptions& options) {
    // Wrong options are refused before anything is read.
    const Topology plan = load_modelled_topology(options.topology, options.overrides);
    std::vector<timing::SweptKey> keys = keys_of(options, plan);
    timing::RunWork work = work_of(options);
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
