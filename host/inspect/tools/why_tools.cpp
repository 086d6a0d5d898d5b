// pxpl5 why and pxpl5 why-not.
#include <fmt/format.h>

#include "host/base/answer.hpp"
#include "host/base/error.hpp"
#include "host/inspect/record/find_run.hpp"
#include "host/inspect/tools/tools.hpp"
#include "host/inspect/why/why_not.hpp"

namespace pxpl5::host::inspect {

namespace {

/// The pixel of the command line of `tool`.
RegionPixel pixel_of(const PixelOptions& options, std::string_view tool) {
    if (!options.x || !options.y) {
        throw RequestError(
            ExitCode::usage,
            fmt::format("X and Y of the pixel are missing; give RUN, X and Y, for example: {} "
                        "latest-recorded 256 200 (RUN is '{}')",
                        tool, options.run));
    }
    return {*options.x, *options.y};
}

}  // namespace

int run_why(const PixelOptions& options) {
    const RegionPixel pixel = pixel_of(options, "why");
    const RecordedRun run = open_run(options.run);
    FrameInquiry frame(run, options.frame);
    write(answer_of(why(frame, pixel.x, pixel.y)), options.json ? Format::json : Format::text,
          options.output);
    return 0;
}

int run_why_not(const WhyNotTool& tool) {
    const RegionPixel pixel = pixel_of(tool, "why-not");
    Expectation expected{std::nullopt, tool.surface, tool.triangle};
    if (!tool.cell.empty()) {
        expected.cell = parse_cell(tool.cell);
    }
    if (tool.triangle && !expected.cell) {
        throw RequestError(ExitCode::usage,
                           "--triangle needs --cell, because triangles are counted per cell");
    }
    const RecordedRun run = open_run(tool.run);
    FrameInquiry frame(run, tool.frame);
    const WhyNotFinding finding = why_not(frame, pixel.x, pixel.y, expected);
    write(answer_of(finding), tool.json ? Format::json : Format::text, tool.output);
    return finding.verdict.verdict == Verdict::unknown ? static_cast<int>(ExitCode::failed) : 0;
}

}  // namespace pxpl5::host::inspect
