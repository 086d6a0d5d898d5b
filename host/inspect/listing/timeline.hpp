// A run as a timeline that Perfetto and chrome://tracing open: JSON trace events.
//
// One process per node. Track "receives": a slice per message, from its receipt to the node's next
// one, but not longer than max_slice_ns, because a trace does not hold busy times.
// Arrows lead to a message from the newest one that its sender had received before it sent.
// Renderers have "draws", from the last RegionPrograms of a frame, or the end of the frame before,
// to RegionPixels at the frame buffer, and "pixel processors (modelled)", each region as long as
// its cycles take at 40 MHz. Source: Trace Event Format, Google, 2016.
#pragma once

#include <cstdint>
#include <string>

#include "host/base/text_output.hpp"
#include "host/inspect/record/recorded_run.hpp"
#include "host/inspect/record/selection.hpp"

namespace pxpl5::host::inspect {

inline constexpr std::int64_t max_slice_ns = 200'000;

struct TimelineCounts {
    std::uint64_t events = 0;             ///< Written; without names of tracks.
    std::uint64_t messages_left_out = 0;  ///< For want of room, the newest ones.
};

/// Writes the selected messages and frames, at most `max_events` events, as one JSON object. Says
/// in "otherData" what was left out.
TimelineCounts put_timeline(const RecordedRun& run, const Selection& selection,
                            std::uint64_t max_events, TextOutput& output);

}  // namespace pxpl5::host::inspect
