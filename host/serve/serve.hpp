// The subcommand `serve`: a machine, a session and a web server.
#pragma once

#include <vector>

#include "host/base/command_line.hpp"
#include "host/machine/machine.hpp"
#include "host/serve/job/job_script.hpp"
#include "host/serve/server/server.hpp"

namespace pxpl5::host::serve {

struct ServeOptions {
    ServerOptions server;  ///< Its folders, except `page`, are created in the run folder.
    Topology topology;
    MachineOptions machine;
    std::vector<Arguments> commands;  ///< Run before viewers join: load, surfaces.
    std::string session;              ///< File of a saved session, played instead of `commands`.
    std::string time_limit;           ///< See parse_time_limit(); empty: none.
    JobOptions job;                   ///< The job that `serve` submits with engine slurm.
};

/// Submits a job that serves, if is_submitted(). Otherwise prints the address and serves until
/// Ctrl-C or SIGTERM, then returns 0. Throws RequestError if a command fails or the server cannot
/// start, MachineError if the machine cannot be started again.
int serve(const ServeOptions& options);

}  // namespace pxpl5::host::serve
