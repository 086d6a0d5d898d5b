// What the nodes have done, for people and for programs.
#pragma once

#include <string>

#include "host/base/reply.hpp"
#include "host/session/activity.hpp"
#include "host/session/session.hpp"

namespace pxpl5::host {

/// A line for each node, and one for the channels of the ring.
std::string activity_text(const ActivityReport& report);

/// The fields of the message `machine` (host/serve/README.md).
Fields activity_fields(const ActivityReport& report, const FrameReport& frame);

/// The same of what has come without waiting: asks the nodes, so that the next call knows more.
Fields activity_fields(Session& session);

}  // namespace pxpl5::host
