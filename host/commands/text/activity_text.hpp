// The nodes' work as a table and as fields.
#pragma once

#include <string>

#include "host/base/reply.hpp"
#include "host/session/activity/activity.hpp"
#include "host/session/session.hpp"

namespace pxpl5::host {

/// One line per node, and one line for the channels of the ring.
std::string activity_text(const ActivityReport& report);

/// The fields of the message `machine` (host/serve/README.md).
Fields activity_fields(const ActivityReport& report, const FrameReport& frame);

/// The fields of the answers that have arrived. Asks the nodes without waiting, for the next call.
Fields activity_fields(Session& session);

}  // namespace pxpl5::host
