// Access control: tokens, cookie, Host and Origin of a request.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "host/serve/server/server.hpp"

namespace pxpl5::host::serve {

/// A request as far as access and routes look at it.
struct Request {
    std::string method, path;
    std::map<std::string, std::string, std::less<>> query;
    std::string host, origin, cookie;  ///< Header lines; empty if there is none.
};

/// Tokens and names that this server accepts.
struct AccessRules {
    std::string driver_token, watcher_token;
    std::string driver_session, watcher_session;  ///< Values of cookies, which are no tokens.
    std::string cookie_name;         ///< Other ports of this computer have cookies of their own.
    std::vector<std::string> names;  ///< Allowed in a Host header, without port, lower case.
    bool encrypted = false;
    /// Allowed in an Origin header, which may have another name than the Host header; lower case.
    std::vector<std::string> portals = {};
};

struct Verdict {
    int status = 200;    ///< 200, 400 or 403.
    std::string reason;  ///< A sentence, unless 200.
    Role role = Role::watcher;
    std::string cookie;  ///< Set-Cookie's value, if the request brought its token in the query.
    bool has_token = false;
};

/// Judges one request, whatever it asks for. The cookie is enough for the files of the page alone:
/// browsers send it to every port of this computer, so other users' servers may know it.
Verdict judge(const AccessRules& rules, const Request& request);

/// Judges a request for anything else, for example the WebSocket: it must have the token.
Verdict judge_by_token(const AccessRules& rules, const Request& request);

/// Lets a portal at each of these hosts, with or without a port, pass requests on. Throws
/// RequestError (usage) for a text that is no host.
void allow_hosts(AccessRules& rules, const std::vector<std::string>& hosts);

/// 128 random bits as 32 hexadecimal digits. Throws RequestError (unavailable) if there are none.
std::string random_token();

/// Whether only this computer can reach the address.
bool is_loopback(const std::string& address);

/// The names by which a server bound to `bind` is reached: of the loopback, for tunnels end there,
/// the address itself, this computer's name, and for 0.0.0.0 or :: all its addresses.
std::vector<std::string> reachable_names(const std::string& bind);

}  // namespace pxpl5::host::serve
