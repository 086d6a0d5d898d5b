#include "host/inspect/tools/cli.hpp"

#include <algorithm>
#include <csignal>
#include <stdexcept>

#include "host/base/text_output.hpp"
#include "host/inspect/tools/cli_declare.hpp"

namespace pxpl5::host::inspect {

namespace {

struct SelectionOption {
    std::string_view name;
    std::vector<std::string> SelectionText::*texts;
    const char* doc;
};

constexpr SelectionOption selection_options[] = {
    {"frame", &SelectionText::frame, "Frames, e.g. 7 or 3-5"},
    {"region", &SelectionText::region, "Regions by number, e.g. 5, or by column,row, e.g. 2,1"},
    {"gp", &SelectionText::gp, "Graphics Processors, e.g. 0-3"},
    {"renderer", &SelectionText::renderer, "Renderers"},
    {"surface", &SelectionText::surface, "Surfaces, by place in the frame's list, from 0"},
    {"slab", &SelectionText::slab, "Slabs: cells between slices n and n+1"},
    {"op", &SelectionText::op, "Instructions by name, e.g. 'TREE*'"},
    {"kind", &SelectionText::kind, "Messages by kind, e.g. 'Region*'"},
};

}  // namespace

void declare_run(CLI::App& app, std::string& run) {
    app.add_option("run", run,
                   "Run folder, its traces folder, or one .mcap file; the newest under run/ if "
                   "not given");
}

void declare_output(CLI::App& app, std::string& output) {
    app.add_option("-o,--output", output, "Write to this file, not to standard output");
}

void declare_json(CLI::App& app, bool& json) {
    app.add_flag("--json", json, "One JSON object, for programs");
}

void declare_selection(CLI::App& app, SelectionText& text,
                       std::initializer_list<std::string_view> which) {
    for (const std::string_view name : which) {
        const auto* option = std::ranges::find(selection_options, name, &SelectionOption::name);
        if (option == std::end(selection_options)) {
            throw std::logic_error("no option of the selection: " + std::string(name));
        }
        app.add_option("--" + std::string(name), text.*option->texts, option->doc)
            ->allow_extra_args(false)
            ->group("Selection");
    }
}

std::function<std::optional<int>()> declare_inspection(CLI::App& app) {
    auto tools = std::make_shared<Tools>();
    CLI::App* trace = app.add_subcommand("trace", "Read, execute and compare recorded runs");
    trace->require_subcommand(1);
    declare_reading(*tools, *trace);
    declare_replaying(*tools, *trace);
    declare_stepping(*tools, *trace);
    declare_programs(*tools, app);
    declare_asking(*tools, app);
    declare_model(*tools, app);
    return [tools]() -> std::optional<int> {
        for (const auto& [tool, run] : tools->list) {
            if (tool->parsed()) {
                std::signal(SIGPIPE, SIG_IGN);  // TextOutput sees it as an error instead.
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
