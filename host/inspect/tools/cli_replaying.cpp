// The command line of replay, diff and shrink.
#include "host/inspect/tools/cli_declare.hpp"
#include "host/inspect/tools/replaying_tools.hpp"

namespace pxpl5::host::inspect {

namespace {

constexpr const char* executor_names = "reference, fast, sse4, avx2, avx512";

void declare_replay(CLI::App& app, ReplayTool& tool) {
    declare_run(app, tool.run);
    declare_selection(app, tool.selection, {"frame", "region", "renderer"});
    app.add_option("--executor", tool.executor,
                   std::string(executor_names) + "; several with commas; both: reference,fast")
        ->capture_default_str();
    app.add_option("--threads", tool.threads, "Regions executed at a time")
        ->check(CLI::Range(1, 64))
        ->capture_default_str();
    declare_json(app, tool.json);
    declare_output(app, tool.output);
}

void declare_diff(CLI::App& app, DiffTool& tool) {
    app.add_option("a", tool.a, "A run")->required();
    app.add_option("b", tool.b, "Another run; without it --executors compares on one");
    declare_selection(app, tool.selection, {"frame", "region", "renderer"});
    app.add_option("--executors", tool.executors,
                   std::string("Two of ") + executor_names + ": the trusted one first");
    declare_json(app, tool.json);
    declare_output(app, tool.output);
}

void declare_shrink(CLI::App& app, ShrinkTool& tool) {
    app.add_option("input", tool.input, "A run, or an assembly file")->required();
    declare_selection(app, tool.selection, {"frame", "region", "renderer"});
    app.add_option("--executors", tool.executors,
                   std::string("Two of ") + executor_names + ": the trusted one first")
        ->capture_default_str();
    app.add_option("--pixel", tool.pixel,
                   "Keep what makes this pixel: X,Y of the picture, or of a program's region");
    app.add_option(
           "--field", tool.field,
           "Of --pixel, in the end: surface, rgb, m8:24, or z, normal_x, normal_y, normal_z, "
           "which shading overwrites")
        ->capture_default_str();
    app.add_option("--is", tool.is, "Value of --field; the one it has in the end if not given");
    app.add_option("-o,--output", tool.output,
                   "Write NAME.pxasm, NAME_test.cpp (doctest) and NAME.pxt (conformance)");
}

}  // namespace

void declare_replaying(Tools& tools, CLI::App& trace) {
    add_tool<ReplayTool>(tools, trace, "replay", "Execute a run again and check what came out",
                         trace_replay, declare_replay);
    add_tool<DiffTool>(tools, trace, "diff",
                       "Tell the first difference of two runs, or of two executors on one",
                       trace_diff, declare_diff);
    add_tool<ShrinkTool>(tools, trace, "shrink",
                         "Reduce a difference, or a pixel's value, to the fewest instructions",
                         trace_shrink, declare_shrink);
}

}  // namespace pxpl5::host::inspect
