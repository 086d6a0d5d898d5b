#include "host/serve/server/server_request.hpp"

#include <libwebsockets.h>

#include <algorithm>
#include <array>
#include <vector>

namespace pxpl5::host::serve {
namespace {

constexpr std::size_t max_header_line = 8192;
constexpr std::size_t max_head_bytes = 2048;  // Of an answer: status and headers.

std::string method_name(int method) {
    switch (method) {
        case LWSHUMETH_GET:
            return "GET";
        case LWSHUMETH_HEAD:
            return "HEAD";
        case LWSHUMETH_POST:
            return "POST";
        case LWSHUMETH_PUT:
            return "PUT";
        default:
            return "this method";
    }
}

}  // namespace

std::string header_of(lws* connection, int token) {
    std::array<char, max_header_line> line{};
    const int size = lws_hdr_copy(connection, line.data(), static_cast<int>(line.size()),
                                  static_cast<lws_token_indexes>(token));
    return size <= 0 ? "" : std::string(line.data(), static_cast<std::size_t>(size));
}

Request read_request(lws* connection) {
    Request request;
    char* path = nullptr;
    int path_size = 0;
    request.method = method_name(lws_http_get_uri_and_method(connection, &path, &path_size));
    if (path != nullptr) {
        request.path.assign(path, static_cast<std::size_t>(path_size));
    }
    request.host = header_of(connection, WSI_TOKEN_HOST);
    request.origin = header_of(connection, WSI_TOKEN_ORIGIN);
    request.cookie = header_of(connection, WSI_TOKEN_HTTP_COOKIE);
    std::array<char, max_header_line> argument{};
    for (int index = 0;; ++index) {
        const int size =
            lws_hdr_copy_fragment(connection, argument.data(), static_cast<int>(argument.size()),
                                  WSI_TOKEN_HTTP_URI_ARGS, index);
        if (size <= 0) {
            break;
        }
        const std::string_view text(argument.data(), static_cast<std::size_t>(size));
        const std::size_t equals = std::min(text.find('='), text.size());
        const std::string_view value = text.substr(std::min(equals + 1, text.size()));
        request.query.emplace(text.substr(0, equals), value);
    }
    return request;
}

int answer(lws* connection, int status, const char* type, std::string_view bytes,
           std::span<const Header> headers, std::string_view caching) {
    std::vector<unsigned char> buffer(LWS_PRE + max_head_bytes + bytes.size());
    unsigned char* const start = buffer.data() + LWS_PRE;
    unsigned char* const end = start + max_head_bytes;
    unsigned char* at = start;
    const auto fails = [&](const Header& header) {
        return lws_add_http_header_by_token(
                   connection, static_cast<lws_token_indexes>(header.token),
                   reinterpret_cast<const unsigned char*>(header.value.data()),
                   static_cast<int>(header.value.size()), &at, end) != 0;
    };
    if (lws_add_http_common_headers(connection, static_cast<unsigned>(status), type, bytes.size(),
                                    &at, end) != 0 ||
        fails({WSI_TOKEN_HTTP_CACHE_CONTROL, caching}) || std::ranges::any_of(headers, fails) ||
        lws_finalize_write_http_header(connection, start, &at, end) != 0) {
        return -1;
    }
    std::copy(bytes.begin(), bytes.end(), start);
    if (lws_write(connection, start, bytes.size(), LWS_WRITE_HTTP_FINAL) < 0) {
        return -1;
    }
    return lws_http_transaction_completed(connection) != 0 ? -1 : 0;
}

int redirect(lws* connection, const std::string& path) {
    std::vector<unsigned char> buffer(LWS_PRE + max_head_bytes + path.size());
    unsigned char* at = buffer.data() + LWS_PRE;
    if (lws_http_redirect(connection, HTTP_STATUS_FOUND,
                          reinterpret_cast<const unsigned char*>(path.data()),
                          static_cast<int>(path.size()), &at, buffer.data() + buffer.size()) < 0) {
        return -1;
    }
    return lws_http_transaction_completed(connection) != 0 ? -1 : 0;
}

}  // namespace pxpl5::host::serve
