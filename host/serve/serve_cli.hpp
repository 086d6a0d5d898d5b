// The options of the viewer on the command line of `pxpl5 serve`.
#pragma once

#include <CLI/CLI.hpp>

#include "host/machine/computers/cluster_settings.hpp"
#include "host/serve/serve.hpp"

namespace pxpl5::host::serve {

/// Adds the options, which fill `options`.
inline void declare_server(CLI::App& app, ServeOptions& options) {
    ServerOptions& server = options.server;
    app.add_option("--port", server.port, "Port; 0 is a free one")->check(CLI::Range(0, 65535));
    app.add_option("--bind", server.bind, "Address to listen at")->capture_default_str();
    app.add_option("--tls-cert", server.tls_cert, "Certificate (PEM)");
    app.add_option("--tls-key", server.tls_key, "Key of the certificate (PEM)");
    app.add_flag("--insecure", server.insecure, "Listen beyond this computer without encryption");
    app.add_option("--allow-host", server.allowed_hosts,
                   "Host of a portal that passes the page on, for example ondemand.example.edu")
        ->allow_extra_args(false)
        ->type_name("NAME[:PORT]");
    app.add_option("--session", options.session, "Open a saved session instead of a volume")
        ->excludes(app.get_option("volume"), app.get_option("--surface"));
    app.add_option("--time-limit", options.time_limit,
                   "Time until this program is ended from outside, to warn 2 minutes before: 90 "
                   "(minutes), 1:30:00 or 1-12 (days-hours); by default that of the Slurm job. "
                   "A job that --engine slurm submits gets this limit");
    app.add_option("--idle-limit", options.idle_limit,
                   "End the session after this time without use, in the same forms; "
                   "viewers are warned, and the session is saved");
    app.add_option("--memory-limit", options.memory_limit,
                   "End the session when its processes on this computer use more memory, for "
                   "example 4GiB or 500MB")
        ->transform(CLI::AsSizeValue(false));
    constexpr int max_sessions = 200;
    app.add_option("--sessions", options.sessions,
                   "Serve a class: each browser that opens the address gets a session and a "
                   "machine of its own, at most this number at the same time. Each ends after 30 "
                   "minutes without use, or when it uses more than its part of the free memory, "
                   "unless the two options above say otherwise")
        ->check(CLI::Range(1, max_sessions));
    app.add_option("--end-with", options.end_with,
                   "End with this process, which must be the parent")
        ->check(CLI::PositiveNumber)
        ->group("");  // For the sessions of a class.
    app.add_option("--class-port", options.class_port, "Port of the page of the class")->group("");
    app.add_option("--nodes", options.job.nodes,
                   "Computers of the job that --engine slurm submits outside of a job")
        ->check(CLI::Range(1, max_computers));
    app.add_option("--sbatch-option", options.job.sbatch,
                   "Option of sbatch for this job, for example --sbatch-option=--partition=gpu")
        ->allow_extra_args(false);
}

}  // namespace pxpl5::host::serve
