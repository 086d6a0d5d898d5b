// Two recorded runs of equal machines, message by message.
#pragma once

#include <optional>
#include <string>

#include "host/inspect/record/recorded_run.hpp"

namespace pxpl5::host::inspect {

/// The first message, by receiver, sender and order, whose kind or body differs, as a sentence;
/// nothing if all are the same, or if the machines have other numbers of nodes. Messages that tell
/// times or keep the connection are left out, as are nodes that lack a trace or kept only the
/// newest messages.
std::optional<std::string> first_message_difference(const RecordedRun& a, const RecordedRun& b);

/// The first slice of the volume that a frame shows in which the runs differ, as a sentence.
std::optional<std::string> slice_difference(const RecordedRun& a, const RecordedRun& b,
                                            std::uint32_t frame);

}  // namespace pxpl5::host::inspect
