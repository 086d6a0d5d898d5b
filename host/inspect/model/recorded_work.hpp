// The work of a recorded run, counted again: the input of the timing model.
//
//   GP 0's trace: order of commands --+
//   traces of GPs: slices, scenes ----+--> recorded_work() --> timing::RunWork
//   the host's: what was extracted ---+
//   Renderers': programs, run again --+
#pragma once

#include <vector>

#include "host/inspect/record/recorded_run.hpp"
#include "host/inspect/record/selection.hpp"
#include "host/timing/counts/work.hpp"

namespace pxpl5::host::inspect {

/// Counts all volumes and surfaces of the run, and those of its frames that are selected, in the
/// order in which the host asked for them. Of what is not recorded, voxels are taken from phantoms
/// and slabs are extracted again; what cannot be counted is left out, and RunWork::missing says so.
/// The same commands give the same work for any number of nodes, but for FrameWork::assignment.
///
/// frames  Numbers of frames; empty: all. A picture's passes are counted if one of them is named.
/// Throws RequestError (bad_data) if GP 0, which is told everything, has no trace.
timing::RunWork recorded_work(const RecordedRun& run, const std::vector<Range>& frames = {});

}  // namespace pxpl5::host::inspect
