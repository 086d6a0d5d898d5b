// The command line of model.
#include "host/inspect/model/model.hpp"
#include "host/inspect/tools/cli_declare.hpp"

namespace pxpl5::host::inspect {

namespace {

void declare_model_options(CLI::App& app, ModelOptions& options) {
    declare_run(app, options.run);
    app.add_option("--topology", options.topology, "Modelled machine: a name or a file")
        ->capture_default_str();
    app.add_option("--set", options.overrides,
                   "Change one value of the machine: gp.count=54, ring.channel_mb_s=160, share=own")
        ->allow_extra_args(false);
    app.add_option("--sweep", options.sweeps,
                   "Time the last picture, or that of --frame, on many machines: gp.count=1..64, "
                   "gp.count=1..64*2, ring.channel_mb_s=40,80,160; twice for two keys")
        ->allow_extra_args(false);
    declare_selection(app, options.selection, {"frame"});
    app.add_option("--csv", options.csv, "Write a table to this file: a line a step, or a machine");
    app.add_option("--plot", options.plot,
                   "Writes the sweep's curves to this file (.svg, .png or .pdf)");
    declare_json(app, options.json);
    declare_output(app, options.output);
}

}  // namespace

void declare_model(Tools& tools, CLI::App& parent) {
    add_tool<ModelOptions>(tools, parent, "model",
                           "Tell what a recorded run takes on the machine of 1993, or on another",
                           run_model, declare_model_options);
}

}  // namespace pxpl5::host::inspect
