// pxpl5 trace step: reads commands from the terminal, standard input or -c, and answers.
#pragma once

#include <string>
#include <vector>

#include "host/inspect/record/selection.hpp"

namespace pxpl5::host::inspect {

struct StepOptions {
    std::string run;
    SelectionText selection;            ///< One frame, and perhaps one region, to begin at.
    std::vector<std::string> commands;  ///< Separated by ';'; instead of those of standard input.
};

/// Returns 0, or the exit code of the first command that failed, behind which a script ends.
/// Throws RequestError.
int trace_step(const StepOptions& options);

}  // namespace pxpl5::host::inspect
