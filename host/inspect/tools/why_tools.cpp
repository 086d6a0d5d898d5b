#include "host/inspect/tools/why_tools.hpp"

#include "host/base/error.hpp"
#include "host/base/text_output.hpp"
#include "host/inspect/record/find_run.hpp"
#include "host/inspect/why/why_not.hpp"

namespace pxpl5::host::inspect {

namespace {

void put(const PixelOptions& options, const Reply& reply) {
    TextOutput output(options.output);
    output.line(options.json ? json_text(reply.fields) : reply.text);
    output.finish();
}

}  // namespace

int run_why(const PixelOptions& options) {
    const RecordedRun run = open_run(options.run);
    FrameInquiry frame(run, options.frame);
    put(options, why_reply(why(frame, options.x, options.y)));
    return 0;
}

int run_why_not(const WhyNotTool& tool) {
    Expectation expected{std::nullopt, tool.surface, tool.triangle};
    if (!tool.cell.empty()) {
        expected.cell = parse_cell(tool.cell);
    }
    if (tool.triangle && !expected.cell) {
        throw RequestError(ExitCode::usage, "--triangle needs --cell: it counts in a cell");
    }
    const RecordedRun run = open_run(tool.pixel.run);
    FrameInquiry frame(run, tool.pixel.frame);
    const WhyNotFinding finding = why_not(frame, tool.pixel.x, tool.pixel.y, expected);
    put(tool.pixel, why_not_reply(finding));
    return finding.verdict.verdict == Verdict::unknown ? static_cast<int>(ExitCode::failed) : 0;
}

}  // namespace pxpl5::host::inspect
