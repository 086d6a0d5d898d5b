// The RUN argument of the tools: which recorded run is meant.
#pragma once

#include <filesystem>
#include <string>

#include "host/inspect/record/recorded_run.hpp"

namespace pxpl5::host::inspect {

/// Where runs are kept unless --run-folder said otherwise.
inline constexpr const char* default_run_folder = "run";

/// A run folder, traces folder or trace file as it is; of nothing or "latest" the newest folder
/// under `base` that holds a trace.
/// Throws RequestError (usage) if there is none.
std::filesystem::path find_run(const std::string& text,
                               const std::filesystem::path& base = default_run_folder);

/// Opens what find_run() finds; says on standard error which one if `text` did not.
RecordedRun open_run(const std::string& text);

}  // namespace pxpl5::host::inspect
