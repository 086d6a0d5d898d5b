// Connections that have not shown a token or a cookie: few, and short.
#include <libwebsockets.h>

#include <algorithm>
#include <array>

#include "host/serve/server/server_access.hpp"
#include "host/serve/server/server_request.hpp"
#include "host/serve/server/strangers.hpp"

namespace pxpl5::host::serve {
namespace {

// Fewer than the connections and the request heads that libwebsockets has room for, so that a
// viewer always finds room. A browser shows its secret with its first request.
constexpr std::ptrdiff_t max_strangers = 48, max_all_at_address = 16;
constexpr lws_usec_t patience = 2 * LWS_USEC_PER_SEC;  ///< For a request's whole head.

}  // namespace

std::string address_of(lws* connection) {
    std::array<char, 64> text{};
    if (lws_get_peer_simple(connection, text.data(), text.size()) == nullptr) {
        return "";
    }
    const std::string address(text.data());
    return is_loopback(address) || address.starts_with("::ffff:127.") ? "loopback" : address;
}

void Strangers::meet(lws* connection) {
    const std::string address = address_of(connection);
    const auto is_from_there = [&](const auto& entry) { return entry.second == address; };
    const bool is_crowd = std::ranges::count_if(all_, is_from_there) >= max_all_at_address;
    if (is_crowd || std::ssize(all_) >= max_strangers) {
        // The oldest goes: what has shown nothing for longest is least likely to be a browser.
        const auto oldest = is_crowd ? std::ranges::find_if(all_, is_from_there) : all_.begin();
        lws* const gone = oldest->first;
        all_.erase(oldest);  // Before its end, which calls forget().
        lws_set_timeout(gone, PENDING_TIMEOUT_KILLED_BY_PARENT, LWS_TO_KILL_SYNC);
    }
    all_.emplace_back(connection, address);
    lws_set_timer_usecs(connection, patience);
}

bool Strangers::has(lws* connection) const {
    return std::ranges::any_of(all_, [&](const auto& entry) { return entry.first == connection; });
}

void Strangers::accept(lws* connection) {
    if (has(connection)) {
        forget(connection);
        lws_set_timer_usecs(connection, LWS_SET_TIMER_USEC_CANCEL);
    }
}

void Strangers::forget(lws* connection) {
    std::erase_if(all_, [&](const auto& entry) { return entry.first == connection; });
}

}  // namespace pxpl5::host::serve
