// The command line of asm, dis and exec.
#include "host/inspect/cli_declare.hpp"

namespace pxpl5::host::inspect {

void declare_programs([[maybe_unused]] Tools& tools, [[maybe_unused]] CLI::App& parent) {}

}  // namespace pxpl5::host::inspect
