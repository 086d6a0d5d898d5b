// The command line of the inspection tools: pxpl5 trace ..., asm, dis, exec, why, why-not.
#pragma once

#include <functional>
#include <optional>

namespace CLI {
class App;
}

namespace pxpl5::host::inspect {

/// Declares the tools as subcommands of `app`. The returned function, called after the command line
/// was parsed, runs the tool that it names and returns the exit code; nothing if it names none.
/// It throws RequestError as the tools do.
std::function<std::optional<int>()> declare_inspection(CLI::App& app);

}  // namespace pxpl5::host::inspect
