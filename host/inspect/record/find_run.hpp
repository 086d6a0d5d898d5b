// The RUN argument of the tools: which recorded run is meant.
#pragma once

#include <filesystem>
#include <string>

#include "host/inspect/record/recorded_run.hpp"

namespace pxpl5::host::inspect {

/// Where runs are kept unless --run-folder said otherwise.
inline constexpr const char* default_run_folder = "run";

/// A run folder, traces folder or trace file as it is. "latest" or nothing is the newest run under
/// `base`, "latest-recorded" the newest run that has a trace.
/// Throws RequestError (usage) if no run has a trace, or if the newest run has none and "latest" is
/// asked for.
std::filesystem::path find_run(const std::string& text,
                               const std::filesystem::path& base = default_run_folder);

/// Opens what find_run() finds; says on standard error which one if `text` did not.
RecordedRun open_run(const std::string& text);

}  // namespace pxpl5::host::inspect
