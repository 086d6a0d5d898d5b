// Ranges that the numbers of a verified message must satisfy, so that nodes can trust them.
#pragma once

#include <string>

#include "ringbus/message.hpp"

namespace pxpl5::bus {

/// Returns "" if all fields are in range, else a text with the first wrong field and both values.
///
/// body_bytes  Size of the message. Lists that share their elements are refused, because a small
///             message could take hours to check otherwise.
std::string out_of_range(const schema::Message& message, std::size_t body_bytes);

}  // namespace pxpl5::bus
