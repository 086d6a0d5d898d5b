// The folder of one run: logs, plan, facts, traces.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "host/machine/topology.hpp"

namespace pxpl5::host {

/// Makes <base>/<utc>-<pid> with config.resolved.json and manifest.json, for the owner alone: logs
/// and traces name and hold patients' data. Returns its absolute path.
///
/// Locks the folder until this process ends. Removes uploads from the runs in `base` whose programs
/// have ended, and these runs except for the newest `keep`; 0 keeps all. Programs on other
/// computers and in other containers may share `base`: a run has ended if its lock is free. A run
/// without a lock file has ended if its manifest is from here and its process is gone.
///
/// Throws RequestError (failed) naming the folder and the reason.
std::filesystem::path make_run_folder(const std::filesystem::path& base, const Topology& topology,
                                      int keep = 0);

/// Writes a new file for the owner alone. Throws RequestError (failed) naming path and reason.
void write_private_file(const std::filesystem::path& path, std::string_view text);

/// Makes the folder for the owner alone unless it exists. Throws RequestError (failed) naming
/// folder and reason if it is no folder, or if another user owns it or may use it: in a shared
/// folder, another user may have made it first.
void make_private_folder(const std::filesystem::path& folder);

/// The last line of a process's log, its reason for ending. Empty if the process wrote no line.
std::string last_words(const std::filesystem::path& log);

}  // namespace pxpl5::host
