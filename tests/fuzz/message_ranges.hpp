// The ranges of the fields of messages, written again from the schema's comments and the limits.
#pragma once

#include "ringbus/message.hpp"

namespace pxpl5::fuzz {

/// Ends the process if a field of an accepted message is outside of its documented range.
void require_documented_ranges(const bus::Message& message);

/// The same for messages about frames, activity and counts alone.
void require_documented_frame(const bus::Message& message);

}  // namespace pxpl5::fuzz
