// The command line of step and map.
#include "host/inspect/map/map_values.hpp"
#include "host/inspect/tools/cli_declare.hpp"
#include "host/inspect/tools/map_tool.hpp"
#include "host/inspect/tools/step_tool.hpp"

namespace pxpl5::host::inspect {

void declare_stepping(Tools& tools, CLI::App& trace) {
    add_tool<StepOptions>(
        tools, trace, "step", "Step through a frame's instructions, forward and backward",
        trace_step, [](CLI::App& app, StepOptions& options) {
            declare_run(app, options.run);
            declare_selection(app, options.selection, {"frame", "region"});
            app.add_option("-c,--command", options.commands,
                           "Run these commands, separated by ';'; 'help' lists them")
                ->allow_extra_args(false);
        });
    add_tool<MapOptions>(
        tools, trace, "map", "Draw what each pixel cost, or where it came from, over the picture",
        trace_map, [](CLI::App& app, MapOptions& options) {
            std::string kinds;
            for (const MapInfo& kind : map_kinds()) {
                kinds += (kinds.empty() ? "" : ", ") + std::string(kind.name);
            }
            app.add_option("run-and-map", options.words,
                           "Run, the newest under run/ if left out, and one of " + kinds)
                ->required()
                ->expected(1, 2);
            declare_selection(app, options.selection, {"frame"});
            app.add_option("-o,--output", options.output, "Picture to write, FILE.png");
            app.add_flag("--raw", options.raw, "Numbers as CSV, a line per row of the picture");
            app.add_flag("--grid", options.grid, "Lines between regions");
        });
}

}  // namespace pxpl5::host::inspect
