// Why a modelled figure is what it is, in words: the busiest unit, the counts that keep it busy,
// and whether the rest is waiting.
#pragma once

#include <string>

#include "host/timing/simulate.hpp"

namespace pxpl5::host::report {

/// time      Of the build, with use and limit.
/// paper_ms  The text gives the counts that this time would need.
std::string build_reason(const timing::Machine& machine, const timing::VolumeWork& volume,
                         const timing::BuildWork& build, const timing::StepTime& time,
                         double paper_ms);

std::string frames_reason(const timing::Machine& machine, const timing::FrameWork& frame,
                          const timing::Rate& rate);

}  // namespace pxpl5::host::report
