// pxpl5 model: what a recorded run takes on the machine of 1993, or on another.
#pragma once

#include <string>
#include <vector>

#include "host/inspect/record/selection.hpp"

namespace pxpl5::host::inspect {

struct ModelOptions {
    std::string run{}, output{};
    std::string topology = "paper-1993";
    std::vector<std::string> overrides{};  ///< As of --set.
    std::vector<std::string> sweeps{};     ///< "gp.count=1..64"
    SelectionText selection{};             ///< Frames.
    std::string csv{}, plot{};             ///< Files; empty for none.
    bool json = false;
};

int run_model(const ModelOptions& options);

}  // namespace pxpl5::host::inspect
