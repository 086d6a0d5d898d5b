// The command line of ls, dump, stats and export.
#include "host/inspect/cli_declare.hpp"
#include "host/inspect/ls.hpp"

namespace pxpl5::host::inspect {

void declare_reading(Tools& tools, CLI::App& trace) {
    add_tool<LsOptions>(tools, trace, "ls", "Tell which nodes, volumes and frames a run holds",
                        trace_ls, [](CLI::App& app, LsOptions& options) {
                            declare_run(app, options.run);
                            declare_json(app, options.json);
                            declare_output(app, options.output);
                        });
}

}  // namespace pxpl5::host::inspect
