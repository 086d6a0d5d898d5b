// Connections that have not shown a token or a cookie.
#pragma once

#include <string>
#include <utility>
#include <vector>

struct lws;

namespace pxpl5::host::serve {

/// Keeps such connections few and short. For a server's thread.
class Strangers {
  public:
    /// Notes a new connection, and ends the oldest if there are too many. The connection gets a
    /// timer (LWS_CALLBACK_TIMER), at which it must be closed if has() is still true.
    void meet(lws* connection);
    /// The connection has shown a secret.
    void accept(lws* connection);
    bool has(lws* connection) const;
    /// The connection has ended.
    void forget(lws* connection);

  private:
    /// The oldest first, with the address of each.
    std::vector<std::pair<lws*, std::string>> all_;
};

}  // namespace pxpl5::host::serve
