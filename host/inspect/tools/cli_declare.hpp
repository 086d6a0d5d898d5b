// What the cli*.cpp files share. CLI11 costs seconds to compile: nothing else includes this.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <initializer_list>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host/inspect/record/selection.hpp"

namespace pxpl5::host::inspect {

/// All tools of the command line.
struct Tools {
    std::vector<std::pair<const CLI::App*, std::function<int()>>> list;
};

/// Adds a tool: subcommand `name` of `parent`, which runs `run` with the options that `declare`
/// binds to the command line. They live as long as `tools`.
template <typename Options, typename Declare>
void add_tool(Tools& tools, CLI::App& parent, const std::string& name, const std::string& doc,
              int (*run)(const Options&), const Declare& declare) {
    CLI::App* app = parent.add_subcommand(name, doc);
    auto options = std::make_shared<Options>();
    declare(*app, *options);
    tools.list.emplace_back(app, [options, run] { return run(*options); });
}

/// The positional RUN argument.
void declare_run(CLI::App& app, std::string& run);
/// -o FILE for text.
void declare_output(CLI::App& app, std::string& output);
/// --json.
void declare_json(CLI::App& app, bool& json);
/// Those options of the selection that the tool obeys, e.g. {"frame", "region"}.
void declare_selection(CLI::App& app, SelectionText& text,
                       std::initializer_list<std::string_view> which);

// The tools of one file each; cli.cpp calls them.
void declare_reading(Tools& tools, CLI::App& trace);    ///< ls, dump, stats, export
void declare_programs(Tools& tools, CLI::App& parent);  ///< asm, dis, exec
void declare_asking(Tools& tools, CLI::App& parent);    ///< why, why-not
void declare_model(Tools& tools, CLI::App& parent);     ///< model
void declare_replaying(Tools& tools, CLI::App& trace);  ///< replay, diff, shrink
void declare_stepping(Tools& tools, CLI::App& trace);   ///< step, map

}  // namespace pxpl5::host::inspect
