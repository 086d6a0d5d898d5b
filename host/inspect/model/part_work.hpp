// The Renderers' work of a recorded frame, for the timing model.
#pragma once

#include <vector>

#include "host/inspect/record/recorded_run.hpp"
#include "host/timing/counts/work.hpp"

namespace pxpl5::host::inspect {

/// Every part of the frame's regions that can be executed, by region, then in order.
std::vector<timing::PartWork> part_work(const RecordedFrame& frame);

}  // namespace pxpl5::host::inspect
