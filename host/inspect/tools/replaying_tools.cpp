// pxpl5 trace replay and diff.
#include "host/inspect/tools/tools.hpp"

#include <fmt/format.h>

#include "host/base/error.hpp"
#include "host/base/text_output.hpp"
#include "host/inspect/diff/diff.hpp"
#include "host/inspect/record/find_run.hpp"
#include "host/inspect/replay/replay.hpp"

namespace pxpl5::host::inspect {

int trace_replay(const ReplayTool& tool) {
    ReplayOptions options;
    options.selection = parse_selection(tool.selection);
    options.executors = parse_executors(tool.executor);
    options.threads = tool.threads;
    const RecordedRun run = open_run(tool.run);
    TextOutput out(tool.output);
    const ReplayReport report = replay(run, options, [&](const FrameReplay& frame) {
        if (!tool.json) {
            out.put(answer_of(frame).text());
            out.flush();  // A frame on the reference takes seconds.
        }
    });
    out.put(tool.json ? rendered(answer_of(report), Format::json) : summary_of(report).text());
    out.finish();
    return report.agrees() ? 0 : 1;
}

int trace_diff(const DiffTool& tool) {
    if (tool.other.empty() && tool.executors.empty()) {
        throw RequestError(ExitCode::usage,
                           "diff needs a second run, or --executors reference,fast");
    }
    DiffOptions options;
    options.selection = parse_selection(tool.selection);
    if (!tool.executors.empty()) {
        const std::vector<ExecutorKind> kinds = parse_executors(tool.executors);
        if (kinds.size() != 2) {
            throw RequestError(ExitCode::usage,
                               fmt::format("--executors {}: give two executors, not {}",
                                           tool.executors, kinds.size()));
        }
        options.trusted = named(kinds[0]);
        options.other = named(kinds[1]);
    }
    const RecordedRun a = open_run(tool.run);
    const DiffReport report = tool.other.empty() ? diff_executors(a, options)
                                                 : diff_runs(a, open_run(tool.other), options);
    write(answer_of(report), tool.json ? Format::json : Format::text, tool.output);
    return report.difference ? 1 : 0;
}

}  // namespace pxpl5::host::inspect
