// pxpl5 trace map: a frame's map, as a picture or as numbers.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/inspect/record/recorded_run.hpp"
#include "host/inspect/record/selection.hpp"

namespace pxpl5::host::inspect {

struct MapOptions {
    std::vector<std::string> words;  ///< The run, which may be left out, and the map's name.
    std::string output;
    SelectionText selection;  ///< One frame; the newest if none.
    bool raw = false;         ///< Numbers as CSV.
    bool grid = false;        ///< Lines between regions.
};

/// Throws RequestError.
int trace_map(const MapOptions& options);

/// The frame that a selection means: its only one; the newest of the run if it selects none.
/// Throws RequestError (usage) if there are several or none.
std::uint32_t one_frame(const RecordedRun& run, const SelectionText& text);

}  // namespace pxpl5::host::inspect
