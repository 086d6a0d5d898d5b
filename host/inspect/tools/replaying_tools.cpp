// pxpl5 trace replay and diff.
#include "host/inspect/tools/replaying_tools.hpp"

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
            out.line(to_text(frame));
            out.finish();  // A frame on the reference takes seconds.
        }
    });
    out.line(tool.json ? json_text(to_fields(report)) : summary_of(report));
    out.finish();
    return report.agrees() ? 0 : 1;
}

int trace_diff(const DiffTool& tool) {
    if (tool.b.empty() && tool.executors.empty()) {
        throw RequestError(ExitCode::usage,
                           "diff needs a second run, or --executors reference,fast");
    }
    DiffOptions options;
    options.selection = parse_selection(tool.selection);
    if (!tool.executors.empty()) {
        const std::vector<ExecutorKind> kinds = parse_executors(tool.executors);
        if (kinds.size() != 2) {
            throw RequestError(ExitCode::usage,
                               fmt::format("--executors {}: two are compared, {} are given",
                                           tool.executors, kinds.size()));
        }
        options.trusted = named(kinds[0]);
        options.other = named(kinds[1]);
    }
    const RecordedRun a = open_run(tool.a);
    const DiffReport report =
        tool.b.empty() ? diff_executors(a, options) : diff_runs(a, open_run(tool.b), options);
    TextOutput out(tool.output);
    out.line(tool.json ? json_text(to_fields(report)) : to_text(report));
    out.finish();
    return report.difference ? 1 : 0;
}

}  // namespace pxpl5::host::inspect
