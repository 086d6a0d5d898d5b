// Ranges that the numbers of a verified message must satisfy, so that nodes can trust them.
#pragma once

#include <string>

#include "ringbus/message.hpp"

namespace pxpl5::bus {

/// Returns "" if all fields are in range, else a text with the first wrong field and both values.
std::string out_of_range(const schema::Message& message);

}  // namespace pxpl5::bus
