// The subcommand `serve`: a machine, a session and a web server.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "host/base/command_line.hpp"
#include "host/machine/topology.hpp"
#include "host/serve/server/server.hpp"

namespace pxpl5::host::serve {

struct ServeOptions {
    ServerOptions server;  ///< Its folders, except `page`, are created in the run folder.
    Topology topology;
    std::filesystem::path run_base;   ///< See MachineOptions::run_base.
    int keep_runs = 0;                ///< See MachineOptions::keep_runs.
    std::vector<std::string> allow;   ///< See MachineOptions::io_allow.
    bool insecure_tcp = false;        ///< See MachineOptions::insecure_tcp.
    bool io_sandbox = true;           ///< See MachineOptions::io_sandbox.
    std::vector<Arguments> commands;  ///< Run before viewers join: load, surfaces.
};

/// Prints the address and serves until Ctrl-C or SIGTERM, then returns 0. Throws RequestError if a
/// command fails or the server cannot start, MachineError if the machine cannot be started again.
int serve(const ServeOptions& options);

}  // namespace pxpl5::host::serve
