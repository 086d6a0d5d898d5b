// The subcommand `serve`: a machine, a session, and a web server before them.
#pragma once

#include <filesystem>
#include <vector>

#include "host/base/command_line.hpp"
#include "host/machine/topology.hpp"
#include "host/serve/server/server.hpp"

namespace pxpl5::host::serve {

struct ServeOptions {
    ServerOptions server;  ///< Its folders but for `page` are made in the run's folder.
    Topology topology;
    std::filesystem::path run_base;   ///< As MachineOptions::run_base.
    std::vector<Arguments> commands;  ///< Done before anybody looks: load, surfaces.
};

/// Prints where to look, and serves until Ctrl-C or SIGTERM, then returns 0. Throws RequestError if
/// the commands fail or nobody can be served, MachineError if the machine dies for good.
int serve(const ServeOptions& options);

}  // namespace pxpl5::host::serve
