// pxpl5 exec: runs assembly on a pixel array and shows the pixels.
#pragma once

#include <string>
#include <vector>

#include "host/base/text_output.hpp"

namespace pxpl5::host::inspect {

struct ExecOptions {
    std::vector<std::string> programs{};  ///< Assembly, or one conformance case; run in this order.
    std::vector<std::string> parameters{}, init{}, prints{};
    std::string executor = "reference", window = "0..15,0..7", pixel{}, picture{}, output{};
    bool hex = false, is_signed = false;
};

/// Runs what the options name; the text goes to `output`. Returns the exit code: failed if a
/// program stopped early, executors differ, or a case is not as expected.
int execute(const ExecOptions& options, TextOutput& output);
int execute_tool(const ExecOptions& options);

}  // namespace pxpl5::host::inspect
