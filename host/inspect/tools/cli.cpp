// The command line of all tools. The only file of the folder that compiles CLI11.
#include "host/inspect/tools/cli.hpp"

#include <CLI/CLI.hpp>
#include <concepts>
#include <csignal>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "host/inspect/map/map_values.hpp"
#include "host/inspect/tools/tools.hpp"

namespace pxpl5::host::inspect {

namespace {

constexpr const char* run_help =
    "Run folder, its traces folder, or one .mcap file; 'latest' is the newest run under run/,"
    " 'latest-recorded' the newest run with a trace";
constexpr const char* executor_names = "reference, fast, sse4, avx2, avx512";
constexpr const char* all_parts = "frame region gp renderer surface slab op kind";

struct SelectionOption {
    std::string_view name;
    std::vector<std::string> SelectionText::*texts;
    const char* doc;
};
constexpr SelectionOption selection_options[] = {
    {"frame", &SelectionText::frame, "Frames, for example 7 or 3-5"},
    {"region", &SelectionText::region, "Regions by number (5) or by column,row (2,1)"},
    {"gp", &SelectionText::gp, "Graphics Processors, for example 0-3"},
    {"renderer", &SelectionText::renderer, "Renderers, for example 0-3"},
    {"surface", &SelectionText::surface, "Surfaces by index in the frame's list, from 0"},
    {"slab", &SelectionText::slab, "Slabs: slab N lies between slices N and N+1"},
    {"op", &SelectionText::op, "Instructions by name, for example 'TREE*'"},
    {"kind", &SelectionText::kind, "Messages by kind, for example 'Region*'"},
};

/// The command line of one tool.
struct Line {
    CLI::App& app;

    template <typename T>
    CLI::Option* option(const std::string& name, T& value, const std::string& doc) const {
        CLI::Option* added = app.add_option(name, value, doc);
        if constexpr (std::same_as<T, std::vector<std::string>>) {
            added->allow_extra_args(!name.starts_with('-'));
        } else if constexpr (!requires { value.has_value(); }) {
            added->capture_default_str();
        }
        return added;
    }
    void flag(const std::string& name, bool& value, const std::string& doc) const {
        app.add_flag(name, value, doc);
    }
    void run(RunOptions& options) const {
        option("run", options.run, std::string(run_help) + " and the default");
    }
    /// parts  Names of the selection's options that the tool obeys, separated by blanks.
    void selection(RunOptions& options, const std::string& parts) const {
        std::istringstream names(parts);
        for (std::string name; names >> name;) {
            for (const SelectionOption& one : selection_options) {
                if (one.name == name) {
                    option("--" + name, options.selection.*one.texts, one.doc)->group("Selection");
                }
            }
        }
    }
    void json(RunOptions& options) const { flag("--json", options.json, "Print one JSON object"); }
    void output(std::string& file) const {
        option("-o,--output", file, "Write to this file instead of standard output");
    }
};

void declare(const Line& line, RunOptions& options) {
    line.run(options);
    line.json(options);
    line.output(options.output);
}

void declare(const Line& line, DumpOptions& options) {
    line.run(options);
    line.selection(options, all_parts);
    line.app.add_option("--pixel", options.pixel, "Show values at this pixel of the picture: X Y")
        ->expected(2);
    line.flag("--instructions", options.instructions,
              "List instructions; --region, --op, --slab and --surface imply this flag");
    line.option("--lines", options.lines, "Print at most N lines");
    line.flag("--all", options.all, "Print all lines");
    line.output(options.output);
}

void declare(const Line& line, StatsOptions& options) {
    line.run(options);
    line.selection(options, all_parts);
    line.json(options);
    line.flag("--csv", options.csv, "Print CSV: one line per part and instruction");
    line.output(options.output);
}

void declare(const Line& line, ExportOptions& options) {
    line.run(options);
    line.option("--chrome", options.chrome,
                "Write a timeline for ui.perfetto.dev or chrome://tracing to this file");
    line.option("--events", options.events, "Write at most N events of the timeline");
    line.option("--messages", options.messages, "Write a table of messages: json or csv");
    line.option("--streams", options.streams,
                "Write the programs of each region as assembly files to this folder");
    line.selection(options, "frame region gp renderer surface slab kind");
    line.output(options.output);
}

void declare(const Line& line, ReplayTool& tool) {
    line.run(tool);
    line.selection(tool, "frame region renderer");
    line.option("--executor", tool.executor,
                std::string(executor_names) +
                    "; separate several with commas; 'both' means reference,fast");
    line.option("--threads", tool.threads, "Execute N regions at the same time")
        ->check(CLI::Range(1, 64));
    line.json(tool);
    line.output(tool.output);
}

void declare(const Line& line, DiffTool& tool) {
    line.option("a", tool.run, "A run")->required();
    line.option("b", tool.other, "Second run; without it, two executors are compared on run A");
    line.selection(tool, "frame region renderer");
    line.option("--executors", tool.executors,
                std::string("Two of ") + executor_names + "; the first is trusted");
    line.json(tool);
    line.output(tool.output);
}

void declare(const Line& line, ShrinkTool& tool) {
    line.option("input", tool.run, "A run, or an assembly file")->required();
    line.selection(tool, "frame region renderer");
    line.option("--executors", tool.executors,
                std::string("Two of ") + executor_names + "; the first is trusted");
    line.option("--pixel", tool.pixel,
                "Keep what draws this pixel: X,Y of the picture, or of the program's region");
    line.option("--field", tool.field,
                "Field of --pixel at the end: surface, rgb, m8:24, or z, normal_x, normal_y, "
                "normal_z, which shading overwrites");
    line.option("--is", tool.is, "Value of --field; default: the value at the end");
    line.option("-o,--output", tool.output,
                "Write NAME.pxasm, NAME_test.cpp (doctest) and NAME.pxt (conformance case)");
}

void declare(const Line& line, StepOptions& options) {
    line.run(options);
    line.selection(options, "frame region");
    line.option("-c,--command", options.commands,
                "Run these commands, separated by ';'; 'help' lists the commands");
}

void declare(const Line& line, MapOptions& options) {
    std::string kinds;
    for (const MapInfo& kind : map_kinds()) {
        kinds += (kinds.empty() ? "" : ", ") + std::string(kind.name);
    }
    line.run(options);
    line.option("map", options.map, "One of " + kinds);
    line.selection(options, "frame");
    line.option("-o,--output", options.output, "Picture file to write: .png, .svg or .pdf");
    line.flag("--raw", options.raw, "Print numbers as CSV, one line per row of the picture");
    line.flag("--grid", options.grid, "Draw lines between regions");
}

void declare(const Line& line, PixelOptions& options) {
    line.option("run", options.run, run_help)->required();
    line.option("x", options.x, "Column of the pixel, from the left edge of the picture");
    line.option("y", options.y, "Row of the pixel, from the top edge of the picture");
    line.option("--frame", options.frame, "Frame; default: the last complete frame");
    line.json(options);
    line.output(options.output);
}

void declare(const Line& line, WhyNotTool& tool) {
    declare(line, static_cast<PixelOptions&>(tool));
    line.option("--cell", tool.cell, "Expected voxel cell: i,j,k");
    line.option("--surface", tool.surface, "Expected surface, by index in the frame's list");
    line.option("--triangle", tool.triangle, "Triangle of the cell, from 0");
}

void declare(const Line& line, ModelOptions& options) {
    line.run(options);
    line.option("--topology", options.topology,
                "Modelled machine: a name or a file; default: paper-1993, with --cluster the nodes "
                "of the run");
    line.option("--set", options.overrides,
                "Change a value of the machine: gp.count=54, ring.channel_mb_s=160, share=own");
    line.option("--sweep", options.sweeps,
                "Time the last picture, or the picture of --frame, on many machines: "
                "gp.count=1..64, gp.count=1..64*2, ring.channel_mb_s=40,80,160; give the option "
                "twice to sweep two keys");
    line.option("--cluster", options.cluster,
                "Model the last picture on this many computers of today instead: 3, 1,2,4 or "
                "1..256*2");
    line.option("--link", options.computers.link,
                "Links of --cluster: 1g, 10g, 25g, 100g or infiniband; default: 10g");
    line.option("--link-mbit", options.computers.link_mbit,
                "Rate of the links of --cluster, in Mbit/s");
    line.option("--cores", options.computers.cores,
                "Cores of each computer of --cluster; default: 8");
    line.option("--cluster-set", options.computers.settings,
                "Change a parameter of the table that --cluster prints: curve=0, core.speed=2");
    line.flag("--host-apart", options.computers.host_apart,
              "Put the host of --cluster on one more computer instead of the first");
    line.selection(options, "frame");
    line.option("--csv", options.csv, "Write a table to this file: a line per step or machine");
    line.option("--plot", options.plot,
                "Write the curves of the sweep to this file (.svg, .png or .pdf)");
    line.json(options);
    line.output(options.output);
}

constexpr const char* parameter_help = "Value of a $name in the text: name=number";

void declare(const Line& line, AsmOptions& options) {
    line.option("file", options.file, "Assembly; - is standard input")->required();
    line.option("--param", options.parameters, parameter_help);
    line.option("-o,--output", options.output,
                "Write binary little-endian words to this file; default: hexadecimal text on "
                "standard output");
    line.flag("--hex", options.hex, "Write hexadecimal text to the file, too");
}

void declare(const Line& line, DisOptions& options) {
    line.option("file", options.file, "Words, binary or hexadecimal text; - is standard input")
        ->required();
    line.flag("--numbered", options.numbered,
              "Print place, raw word and cycles before each line; asm cannot read this form");
    line.flag("--hex", options.hex, "The file is hexadecimal text");
    line.flag("--binary", options.binary, "The file is binary");
    line.output(options.output);
}

void declare(const Line& line, ExecOptions& options) {
    line.option("program", options.programs,
                "Assembly files, run one after the other, or one conformance case")
        ->required();
    line.option("--init", options.init,
                "State before the run: FIELD=VALUE or FIELD@PIXELS=VALUE, for example m0:8=x+2*y "
                "or enable@0..63,*=1; everything else is 0");
    line.option("--param", options.parameters, parameter_help);
    line.option("--executor", options.executor,
                std::string(executor_names) + ", or both; several executors are compared");
    line.option("--print", options.prints,
                "Print a field: z, rgb, m88:16, enable, carry, bs3, readout");
    line.option("--window", options.window, "Print these pixels");
    line.option("--pixel", options.pixel, "Print the fields of this pixel, x,y, and no table");
    line.flag("--hex", options.hex, "Print hexadecimal numbers");
    line.flag("--signed", options.is_signed, "Print fields as signed numbers");
    line.option("--picture", options.picture, "Draw this field as a picture; needs -o");
    line.option("-o,--output", options.output, "Picture file to write, FILE.png");
}

/// The tools of a command line.
struct Tools {
    std::vector<std::pair<const CLI::App*, std::function<int()>>> list{};

    template <typename Options>
    void add(CLI::App& parent, const std::string& name, const std::string& doc,
             int (*run)(const Options&)) {
        CLI::App* app = parent.add_subcommand(name, doc);
        auto options = std::make_shared<Options>();
        declare(Line{*app}, *options);
        list.emplace_back(app, [options, run] { return run(*options); });
    }
};

}  // namespace

std::function<std::optional<int>()> declare_inspection(CLI::App& app) {
    auto tools = std::make_shared<Tools>();
    CLI::App& trace = *app.add_subcommand("trace", "Read, execute and compare recorded runs");
    trace.require_subcommand(1);
    tools->add(trace, "ls", "List the nodes, volumes and frames of a run", trace_ls);
    tools->add(trace, "dump", "List messages, or the instructions of a region with their results",
               trace_dump);
    tools->add(trace, "stats", "Count instructions, cycles and messages", trace_stats);
    tools->add(trace, "export", "Write a timeline, a table of messages, or assembly files",
               trace_export);
    tools->add(trace, "replay", "Execute a run again and compare the results with the recording",
               trace_replay);
    tools->add(trace, "diff", "Find the first difference of two runs, or of two executors on a run",
               trace_diff);
    tools->add(trace, "shrink", "Reduce a difference, or a pixel's value, to few instructions",
               trace_shrink);
    tools->add(trace, "step", "Step through the instructions of a frame, forward and backward",
               trace_step);
    tools->add(trace, "map", "Draw the cost or the provenance of each pixel over the picture",
               trace_map);
    tools->add(app, "asm", "Assemble a program into instruction words", assemble_tool);
    tools->add(app, "dis", "Disassemble instruction words", disassemble_tool);
    tools->add(app, "exec", "Run assembly on a pixel array and print pixels", execute_tool);
    tools->add(app, "why", "Explain the color of a pixel, down to the eight voxels", run_why);
    tools->add(app, "why-not", "Explain why a surface or a triangle is not visible at a pixel",
               run_why_not);
    tools->add(app, "model", "Model the time of a recorded run on the machine of 1993, or another",
               run_model);
    return [tools]() -> std::optional<int> {
        for (const auto& [tool, run] : tools->list) {
            if (tool->parsed()) {
                std::signal(SIGPIPE, SIG_IGN);  // TextOutput reports a closed pipe instead.
                try {
                    return run();
                } catch (const OutputClosed&) {
                    return 0;
                }
            }
        }
        return std::nullopt;
    };
}

}  // namespace pxpl5::host::inspect
