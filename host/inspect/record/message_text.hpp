// A recorded message in one line.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "ringbus/message.hpp"

namespace pxpl5::host::inspect {

/// The fields that matter, without kind and header: "frame 3, gp-7: 5 regions, 4,182 words". Empty
/// for a message without fields.
std::string describe(const bus::Message& message);

/// The frame that the message belongs to; nothing for kinds that belong to none.
std::optional<std::uint32_t> frame_of(const bus::Message& message);
/// True if messages of this kind belong to a frame.
bool is_of_frame(bus::Body kind);

}  // namespace pxpl5::host::inspect
