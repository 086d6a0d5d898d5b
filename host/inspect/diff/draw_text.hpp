// Writes a frame's request and set-up as named values. Equal requests have equal texts.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "ringbus/message.hpp"

namespace pxpl5::host::inspect {

using NamedValues = std::vector<std::pair<std::string, std::string>>;

/// Every value of the request that the picture depends on; doubles to the last bit.
NamedValues values_of(const bus::schema::DrawFrame& draw);

/// VolumeHeader, SetSurface and RemoveSurface; empty for other kinds.
NamedValues setup_values_of(const bus::Message& message);

}  // namespace pxpl5::host::inspect
