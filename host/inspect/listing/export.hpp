// pxpl5 trace export: a run for other tools, as timeline, table or assembly.
#pragma once

#include <cstdint>
#include <string>

#include "host/inspect/record/selection.hpp"

namespace pxpl5::host::inspect {

struct ExportOptions {
    /// Viewers of timelines get slow, or give up, above a million.
    static constexpr std::uint64_t default_events = 500'000;

    std::string run{}, output{};
    SelectionText selection;
    std::string chrome{};                   ///< File of the timeline; empty: none.
    std::string streams{};                  ///< Folder for assembly files; empty: none.
    std::string messages{};                 ///< "json" or "csv"; empty: none.
    std::uint64_t events = default_events;  ///< Of the timeline, at most.
};

int trace_export(const ExportOptions& options);

}  // namespace pxpl5::host::inspect
