// pxpl5 trace dump: the messages of a run, or the instructions of its regions with results.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/inspect/record/selection.hpp"

namespace pxpl5::host::inspect {

struct DumpOptions {
    static constexpr std::uint64_t default_lines = 2000;

    std::string run{}, output{};
    SelectionText selection;
    std::vector<int> pixel;  ///< Empty, or x and y in the picture.
    std::uint64_t lines = default_lines;
    bool all = false, instructions = false;
};

int trace_dump(const DumpOptions& options);

}  // namespace pxpl5::host::inspect
