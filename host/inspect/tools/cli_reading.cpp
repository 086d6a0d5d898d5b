// The command line of ls, dump, stats and export.
#include "host/inspect/listing/dump.hpp"
#include "host/inspect/listing/export.hpp"
#include "host/inspect/listing/ls.hpp"
#include "host/inspect/listing/stats.hpp"
#include "host/inspect/tools/cli_declare.hpp"

namespace pxpl5::host::inspect {

namespace {

void declare_dump(CLI::App& app, DumpOptions& options) {
    declare_run(app, options.run);
    declare_selection(app, options.selection,
                      {"frame", "region", "gp", "renderer", "surface", "slab", "op", "kind"});
    app.add_option("--pixel", options.pixel,
                   "Show instructions with their values at this pixel of the picture: X Y")
        ->expected(2);
    app.add_flag("--instructions", options.instructions,
                 "Instructions, not messages; --region, --op, --slab, --surface imply it");
    app.add_option("--lines", options.lines, "At most so many lines")->capture_default_str();
    app.add_flag("--all", options.all, "All lines");
    declare_output(app, options.output);
}

void declare_stats(CLI::App& app, StatsOptions& options) {
    declare_run(app, options.run);
    declare_selection(app, options.selection,
                      {"frame", "region", "gp", "renderer", "surface", "slab", "op", "kind"});
    declare_json(app, options.json);
    app.add_flag("--csv", options.csv, "Comma-separated: one line per part and instruction");
    declare_output(app, options.output);
}

void declare_export(CLI::App& app, ExportOptions& options) {
    declare_run(app, options.run);
    app.add_option("--chrome", options.chrome,
                   "Write a timeline for ui.perfetto.dev or chrome://tracing to this file");
    app.add_option("--events", options.events, "At most so many events of the timeline")
        ->capture_default_str();
    app.add_option("--messages", options.messages, "Write a table of messages: json or csv");
    app.add_option("--streams", options.streams,
                   "Write each region's programs as assembly files into this folder");
    declare_selection(app, options.selection,
                      {"frame", "region", "gp", "renderer", "surface", "slab", "kind"});
    declare_output(app, options.output);
}

}  // namespace

void declare_reading(Tools& tools, CLI::App& trace) {
    add_tool<LsOptions>(tools, trace, "ls", "Tell which nodes, volumes and frames a run holds",
                        trace_ls, [](CLI::App& app, LsOptions& options) {
                            declare_run(app, options.run);
                            declare_json(app, options.json);
                            declare_output(app, options.output);
                        });
    add_tool<DumpOptions>(tools, trace, "dump",
                          "List messages, or a region's instructions with their results",
                          trace_dump, declare_dump);
    add_tool<StatsOptions>(tools, trace, "stats", "Count instructions, cycles and messages",
                           trace_stats, declare_stats);
    add_tool<ExportOptions>(tools, trace, "export",
                            "Write a timeline, a table of messages, or assembly files",
                            trace_export, declare_export);
}

}  // namespace pxpl5::host::inspect
