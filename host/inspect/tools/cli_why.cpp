// The command line of why and why-not.
#include "host/inspect/tools/cli_declare.hpp"
#include "host/inspect/tools/why_tools.hpp"

namespace pxpl5::host::inspect {

namespace {

void declare_pixel(CLI::App& app, PixelOptions& options) {
    app.add_option("run", options.run,
                   "Run folder, its traces folder, or one .mcap file; latest: the newest under "
                   "run/")
        ->required();
    app.add_option("x", options.x, "Pixel, from the picture's left")->required();
    app.add_option("y", options.y, "Pixel, from the picture's top")->required();
    app.add_option("--frame", options.frame, "Frame; the last complete one if not given");
    declare_json(app, options.json);
    declare_output(app, options.output);
}

void declare_why_not_options(CLI::App& app, WhyNotTool& tool) {
    declare_pixel(app, tool.pixel);
    app.add_option("--cell", tool.cell, "Voxel cell that is expected there: i,j,k");
    app.add_option("--surface", tool.surface,
                   "Surface that is expected there, by place in the frame's list, from 0");
    app.add_option("--triangle", tool.triangle, "Triangle of the cell, from 0");
}

}  // namespace

void declare_asking(Tools& tools, CLI::App& parent) {
    add_tool<PixelOptions>(tools, parent, "why",
                           "Tell why a pixel has its colour, down to the eight voxels", run_why,
                           declare_pixel);
    add_tool<WhyNotTool>(tools, parent, "why-not",
                         "Tell why what is expected at a pixel is not there", run_why_not,
                         declare_why_not_options);
}

}  // namespace pxpl5::host::inspect
