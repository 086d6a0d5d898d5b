// The first difference between a region's programs in two recorded runs.
#pragma once

#include <optional>

#include "host/inspect/diff/diff.hpp"

namespace pxpl5::host::inspect {

/// A difference of level "message".
Difference message_difference(std::uint32_t frame, const std::string& text);

/// The text calls the runs A and B. Streams are identified by surface and slab, not by GP.
std::optional<Difference> compare_streams(const RecordedFrame& frame_a, const RecordedRegion& a,
                                          const RecordedFrame& frame_b, const RecordedRegion& b);

}  // namespace pxpl5::host::inspect
