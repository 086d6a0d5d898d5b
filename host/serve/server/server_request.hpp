// Requests and answers in libwebsockets' words.
#pragma once

#include <string>
#include <string_view>

#include "host/serve/server/server_access.hpp"

struct lws;

namespace pxpl5::host::serve {

/// The other end's address; "loopback" for every address of this computer alone.
std::string address_of(lws* connection);

/// token  One of libwebsockets' WSI_TOKEN_. Empty if there is no such header, or it is too long.
std::string header_of(lws* connection, int token);

/// Path and query come decoded.
Request read_request(lws* connection);

/// Answers the request with a short text. Returns other than 0 to close the connection.
///
/// cookie  Value of Set-Cookie; empty: none.
int answer(lws* connection, int status, const char* type, std::string_view text,
           std::string_view cookie = {});

/// Sends the browser to another path of this server, or to another server. Returns other than 0 to
/// close the connection.
int redirect(lws* connection, const std::string& path);

}  // namespace pxpl5::host::serve
