// The subcommand `serve`: a machine, a session and a web server.
#pragma once

#include <cstdint>
#include <string>
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
    std::string time_limit;           ///< See parse_duration(); empty: none.
    std::string idle_limit;           ///< The longest time without use, as above; empty: none.
    std::uint64_t memory_limit = 0;   ///< Bytes of all processes on this computer; 0: none.
    int sessions = 0;                 ///< The most at the same time in a class; 0: no class.
    int end_with = 0;                 ///< The parent whose end ends this process; 0: none.
    int class_port = 0;               ///< Port of the page of the class; 0: no class.
    JobOptions job;                   ///< The job that `serve` submits with engine slurm.
};

/// Serves a class if `sessions` says so. Submits a job that serves, if is_submitted(). Otherwise
/// prints the address and serves until Ctrl-C, SIGTERM or the limit for use, then returns 0, or
/// until the limit of memory, then returns 1. Throws RequestError if a command fails or the server
/// cannot start, MachineError if the machine cannot be started again.
int serve(const ServeOptions& options);

}  // namespace pxpl5::host::serve
