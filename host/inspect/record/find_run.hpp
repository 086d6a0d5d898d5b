// The RUN argument of the tools: which recorded run is meant.
#pragma once

#include <filesystem>
#include <string>

#include "host/base/state_folder.hpp"
#include "host/inspect/record/recorded_run.hpp"
#include "host/inspect/record/selection.hpp"

namespace pxpl5::host::inspect {

/// Returns the path of a run folder, traces folder or trace file unchanged. An empty text and
/// "latest" mean the newest run under `base`, "latest-recorded" the newest run that has a trace.
/// Throws RequestError (usage) if no run has a trace, or if the text means the newest run and that
/// run has none.
std::filesystem::path find_run(const std::string& text,
                               const std::filesystem::path& base = default_run_base());

/// Opens the run that find_run() finds. Prints its path on standard error if `text` does not name
/// it.
RecordedRun open_run(const std::string& text);

/// The one frame that a selection names; the newest frame of the run if it names none.
/// Throws RequestError (usage) if the run does not have the frame, or if several are selected.
std::uint32_t one_frame(const RecordedRun& run, const SelectionText& text);

}  // namespace pxpl5::host::inspect
