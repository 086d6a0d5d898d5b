// Ends a running session in order.
#pragma once

#include "host/machine/sessions/session_list.hpp"

namespace pxpl5::host {

/// Sends SIGTERM to the program of the session and waits until it has ended. Returns the
/// milliseconds that this took. Never signals another process, even if the process id was used
/// again.
///
/// Throws RequestError: unavailable with the line to run, if the session runs on another computer;
/// failed if it has not ended within `limit_ms` or may not be signaled.
int end_session(const RunningSession& session, int limit_ms);

}  // namespace pxpl5::host
