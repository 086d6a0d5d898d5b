// Recorded regions as assembly files, ready for `pxpl5 exec`.
#pragma once

#include <cstddef>
#include <filesystem>

#include "host/inspect/record/recorded_run.hpp"
#include "host/inspect/record/selection.hpp"

namespace pxpl5::host::inspect {

struct StreamFiles {
    std::size_t files = 0, regions = 0;
};

/// Writes, into folder/frame-N, the files of each selected region: the programs that it begins and
/// ends with, and what the GPs sent. Segments that run straight on lie in one file; one that
/// branches or ends itself has a file of its own, since its addresses count from its begin:
///
///   region-5.0.prologue.pxasm  region-5.1.pxasm  region-5.2.end.pxasm
///
/// In the order of their names `pxpl5 exec` runs them as the Renderer did, unless a GP, surface or
/// slab is selected. Throws RequestError (failed) if a file cannot be written.
StreamFiles write_streams(const RecordedRun& run, const Selection& selection,
                          const std::filesystem::path& folder);

}  // namespace pxpl5::host::inspect
