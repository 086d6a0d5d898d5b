// The command line of `pxpl5 sessions`.
#pragma once

#include <functional>
#include <optional>

namespace CLI {
class App;
}

namespace pxpl5::host {

/// Declares the subcommand. The returned function, called after the command line was parsed, runs
/// it and returns the exit code; nothing if another subcommand was given. It throws RequestError.
std::function<std::optional<int>()> declare_sessions(CLI::App& app);

}  // namespace pxpl5::host
