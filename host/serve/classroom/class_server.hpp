// `pxpl5 serve --sessions N`: starts a session for each browser, and ends them all.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "host/serve/server/server.hpp"

namespace pxpl5::host::serve {

struct ClassOptions {
    int sessions = 0;                ///< At the same time; 0: no class.
    std::vector<std::string> words;  ///< The user's command line after `serve`.
    std::filesystem::path run_base;  ///< Parent of the sessions' run folders.
    int fitted_cores = 0;            ///< If the topology has a GP per core: the number of cores.
    std::string idle_limit;          ///< The limit of each session; empty: 30 minutes.
    std::uint64_t memory_limit = 0;  ///< The limit of each session, in bytes; 0: see README.md.
    std::optional<std::int64_t> end_s = {};  ///< The end of all, in seconds since 1970.
};

/// Starts a first session, which shows that the options are right. Then prints the address of the
/// class and serves it until Ctrl-C or SIGTERM, ends all sessions, and returns 0. Each session is a
/// `pxpl5 serve` with the user's options, so that it has the same volume, topology and engine.
///
/// server  Its port is that of the class. With a port, the sessions have the ports after it.
/// Throws RequestError as Server does, with the error of the first session if this cannot start,
/// and unavailable if the server cannot go on; MachineError if processes cannot be watched.
int serve_class(const ClassOptions& options, const ServerOptions& server);

}  // namespace pxpl5::host::serve
