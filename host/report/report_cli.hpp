// The command line of `pxpl5 report`.
#pragma once

#include <CLI/CLI.hpp>

#include "host/report/report.hpp"

namespace pxpl5::host::report {

/// Adds the subcommand, which fills `options`.
inline CLI::App* declare_report(CLI::App& parent, ReportOptions& options) {
    CLI::App* app = parent.add_subcommand(
        "report",
        "Print the paper's results, modelled and measured; --topology and --set choose the "
        "modelled machine (default paper-1993)");
    app->add_flag("--paper", options.paper, "Run the paper's results table again");
    app->add_flag("--scaling", options.scaling,
                  "Model the speed-up with 1 to 64 GPs and Renderers");
    app->add_flag("--cluster", options.cluster,
                  "With --scaling: model 1 to 256 computers of today instead");
    app->add_option("--link", options.computers.link,
                    "Links of --cluster: 1g, 10g, 25g, 100g or infiniband; default: 10g");
    app->add_option("--link-mbit", options.computers.link_mbit,
                    "Rate of the links of --cluster, in Mbit/s");
    app->add_option("--cores", options.computers.cores,
                    "Cores of each computer of --cluster; default: 8");
    app->add_option("--cluster-set", options.computers.settings,
                    "Change a parameter of the table that --cluster prints: curve=0, core.speed=2")
        ->allow_extra_args(false);
    app->add_option("rows", options.rows, "Rows to run: pelvis/skin, pelvis/muscle, ...");
    app->add_option("--data", options.data, "Folder of real volumes with the paper's loads");
    app->add_flag("--sensitivity", options.sensitivity,
                  "Print how modelled figures change with each parameter");
    app->add_flag("--fit", options.fit, "Refit the fitted parameters");
    app->add_flag("--json", options.json, "Print one JSON object instead of text");
    app->add_option("--csv", options.csv, "Write the table to this file");
    app->add_option("--picture", options.picture,
                    "Write the plot to this file (.svg, .png or .pdf)");
    app->add_option("--pictures", options.pictures,
                    "Folder for pictures of the surfaces, which are shaded with gradient=smooth");
    return app;
}

}  // namespace pxpl5::host::report
