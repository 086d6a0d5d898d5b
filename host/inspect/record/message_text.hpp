// A recorded message in one line.
#pragma once

#include <cstdint>
#include <string>

#include "ringbus/message.hpp"

namespace pxpl5::host::inspect {

/// The fields that matter, without kind and header: "frame 3, gp-7: 5 regions, 4,182 words". Empty
/// for a message without fields.
std::string describe(const bus::Message& message);

}  // namespace pxpl5::host::inspect
