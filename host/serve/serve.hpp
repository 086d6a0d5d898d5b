// The subcommand `serve`: a machine, a session and a web server.
#pragma once

#include <filesystem>
#include <vector>

#include "host/base/command_line.hpp"
#include "host/machine/topology.hpp"
#include "host/serve/server/server.hpp"

namespace pxpl5::host::serve {

struct ServeOptions {
    ServerOptions server;  ///< Its folders, except `page`, are created in the run folder.
    Topology topology;
    std::filesystem::path run_base;   ///< See MachineOptions::run_base.
    std::vector<Arguments> commands;  ///< Run before viewers join: load, surfaces.
};

/// Prints the address and serves until Ctrl-C or SIGTERM, then returns 0. Throws RequestError if a
/// command fails or the server cannot start, MachineError if the machine has died too often.
int serve(const ServeOptions& options);

}  // namespace pxpl5::host::serve
