// The first difference between a region's programs in two recorded runs.
#pragma once

#include <optional>

#include "host/inspect/diff/diff.hpp"

namespace pxpl5::host::inspect {

/// A difference of level "message".
Difference message_difference(std::uint32_t frame, const std::string& text,
                              const Fields& fields = {});

/// The runs are called A and B. Streams are told apart by surface and slab, whoever drew them.
std::optional<Difference> compare_streams(const RecordedFrame& frame_a, const RecordedRegion& a,
                                          const RecordedFrame& frame_b, const RecordedRegion& b);

}  // namespace pxpl5::host::inspect
