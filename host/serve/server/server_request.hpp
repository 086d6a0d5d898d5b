// Requests and answers in libwebsockets' words.
#pragma once

#include <span>
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

/// A header of an answer.
struct Header {
    int token = 0;  ///< One of libwebsockets' WSI_TOKEN_.
    std::string_view value;
};

/// Values of Cache-Control.
constexpr std::string_view kept_by_nobody = "no-store";
constexpr std::string_view kept_by_browsers = "private, max-age=31536000, immutable";

/// Answers the request with bytes that are at hand. Returns other than 0 to close the connection.
int answer(lws* connection, int status, const char* type, std::string_view bytes,
           std::span<const Header> headers = {}, std::string_view caching = kept_by_nobody);

/// Sends the browser to another path of this server, or to another server. Returns other than 0 to
/// close the connection.
int redirect(lws* connection, const std::string& path);

}  // namespace pxpl5::host::serve
