// pxpl5 trace stats: counts of instructions, cycles and messages.
#pragma once

#include <string>

#include "host/inspect/record/selection.hpp"

namespace pxpl5::host::inspect {

struct StatsOptions {
    std::string run{}, output{};
    SelectionText selection;
    bool json = false, csv = false;
};

int trace_stats(const StatsOptions& options);

}  // namespace pxpl5::host::inspect
