// Requests that are not WebSockets: files, downloads, uploads.
#include <fmt/format.h>
#include <libwebsockets.h>

#include <array>
#include <charconv>
#include <nlohmann/json.hpp>
#include <vector>

#include "host/serve/server/server_loop.hpp"
#include "host/serve/server/server_request.hpp"

namespace pxpl5::host::serve {
namespace {

constexpr const char* plain_text = "text/plain; charset=utf-8";
constexpr const char* json_type = "application/json";
constexpr int too_large = 413;

std::string json_text(const nlohmann::json& json) {
    // Names of files need not be UTF-8.
    return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

int answer_upload(lws* connection, const UploadError& error) {
    return answer(connection, error.status, json_type, json_text({{"error", error.text}}));
}

/// For a request whose body is not read: what is left of it must not be taken for a request.
int refuse(lws* connection, int status, const std::string& text) {
    (void)answer(connection, status, plain_text, text + "\n");
    return -1;
}

std::string parameter(const Request& request, std::string_view name) {
    const auto found = request.query.find(name);
    return found == request.query.end() ? "" : found->second;
}

template <typename T>
std::optional<T> number(const std::string& text) {
    T value{};
    const char* end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, value);
    return error == std::errc{} && stop == end ? std::optional(value) : std::nullopt;
}

/// In a header's quotes only what needs no escape.
std::string quoted_name(std::string name) {
    for (char& c : name) {
        if (c == '"' || c == '\\' || static_cast<signed char>(c) < ' ') {
            c = '_';
        }
    }
    return name;
}

/// Sends a browser from "/node/n1/4711" to "/node/n1/4711/".
int add_slash(lws* connection, const Request& request) {
    constexpr const char* plain =
        "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-._~/";
    // Nothing else: a header would end, or another host would begin with "//".
    if (request.path.find_first_not_of(plain) != std::string::npos ||
        request.path.find("//") != std::string::npos) {
        return refuse(connection, 404, "This path does not exist.");
    }
    const std::string token = parameter(request, "token");
    return redirect(connection, request.path + (token.empty() ? "/" : "/?token=" + token));
}

}  // namespace

int Loop::on_http_event(lws* connection, int reason, std::string_view data) {
    switch (reason) {
        case LWS_CALLBACK_HTTP:
            return on_request(connection);
        case LWS_CALLBACK_HTTP_FILE_COMPLETION:
            return lws_http_transaction_completed(connection) != 0 ? -1 : 0;
        case LWS_CALLBACK_HTTP_BODY: {
            const auto found = uploading_.find(connection);
            if (found == uploading_.end() || found->second.error) {
                return 0;
            }
            try {
                if (found->second.files) {
                    found->second.files->append(data);
                } else {
                    found->second.file->append(data);
                }
            } catch (const UploadError& error) {
                found->second = {nullptr, nullptr, error};
            }
            return 0;
        }
        case LWS_CALLBACK_HTTP_BODY_COMPLETION:
            return end_upload(connection);
        default:
            return 0;
    }
}

int Loop::on_request(lws* connection) {
    const Request request = read_request(connection);
    const Verdict verdict = judge(listener_.rules(), request);
    if (verdict.status != 200) {
        return refuse(connection, verdict.status, verdict.reason);
    }
    strangers_.accept(connection);
    const Route route = routes_.find(request.path, listener_.port());
    const bool sends = request.method == "POST" || request.method == "PUT";
    const bool takes = route.kind == RouteKind::upload || route.kind == RouteKind::upload_files ||
                       route.kind == RouteKind::upload_done;
    if ((takes || route.is_download) && !verdict.has_token) {
        return refuse(connection, 403, judge_by_token(listener_.rules(), request).reason);
    }
    if (route.is_download && verdict.role != Role::driver) {  // Whether the file exists or not.
        return refuse(connection, 403, "A view-only address cannot download files.");
    }
    if (route.kind == RouteKind::none) {
        return refuse(connection, 404, fmt::format("{} does not exist.", request.path));
    }
    if (takes ? !sends : request.method != "GET" && request.method != "HEAD") {
        return refuse(connection, 405,
                      fmt::format("{} does not accept {}.", request.path, request.method));
    }
    if (takes && verdict.role != Role::driver) {
        return refuse(connection, 403, "A view-only address cannot upload files.");
    }
    switch (route.kind) {
        case RouteKind::upload:
            return begin_upload(connection, request, false);
        case RouteKind::upload_files:
            return begin_upload(connection, request, true);
        case RouteKind::upload_done:
            return end_batch(connection, request);
        case RouteKind::slash:
            return add_slash(connection, request);
        case RouteKind::file:
            // With the page alone: the cookie belongs to the folder of what comes with it.
            return send_file(connection, request, route.file,
                             route.file.is_page ? verdict.cookie : "");
        default:
            return refuse(connection, 426, "This path accepts WebSocket connections only.");
    }
}

int Loop::send_file(lws* connection, const Request& request, const ServedFile& file,
                    const std::string& cookie) {
    // Downloads may be large: they are sent from the file, not from memory.
    const bool may_be_gzip = request.method == "GET" && file.attachment.empty() &&
                             accepts_gzip(header_of(connection, WSI_TOKEN_HTTP_ACCEPT_ENCODING)) &&
                             header_of(connection, WSI_TOKEN_HTTP_RANGE).empty();
    if (const std::string* gzip = may_be_gzip ? compressed_.find(file.path) : nullptr) {
        std::vector<Header> with = {{WSI_TOKEN_HTTP_CONTENT_ENCODING, "gzip"},
                                    {WSI_TOKEN_HTTP_VARY, "Accept-Encoding"}};
        if (!cookie.empty()) {
            with.push_back({WSI_TOKEN_HTTP_SET_COOKIE, cookie});
        }
        const bool never_changes = file.is_bundled && !file.is_page && request.query.contains("v");
        return answer(connection, 200, file.type.c_str(), *gzip, with,
                      never_changes ? kept_by_browsers : kept_by_nobody);
    }
    std::string headers;
    if (!cookie.empty()) {
        headers += fmt::format("set-cookie: {}\r\n", cookie);
    }
    if (!file.attachment.empty()) {
        headers += fmt::format("content-disposition: attachment; filename=\"{}\"\r\n",
                               quoted_name(file.attachment));
    }
    const int sent = lws_serve_http_file(connection, file.path.c_str(), file.type.c_str(),
                                         headers.data(), static_cast<int>(headers.size()));
    return sent < 0 || (sent > 0 && lws_http_transaction_completed(connection) != 0) ? -1 : 0;
}

int Loop::begin_upload(lws* connection, const Request& request, bool is_several) {
    const auto length = number<std::uint64_t>(header_of(connection, WSI_TOKEN_HTTP_CONTENT_LENGTH));
    // With both, a proxy before this server could see another end of the request.
    if (!length || !header_of(connection, WSI_TOKEN_HTTP_TRANSFER_ENCODING).empty()) {
        return refuse(connection, 411,
                      "An upload needs a Content-Length header and no Transfer-Encoding.");
    }
    Upload upload;
    const std::string batch = parameter(request, "batch");
    try {
        if (is_several) {
            upload.files = std::make_unique<UploadingFiles>(uploads_, batch);
        } else {
            upload.file = uploads_.begin(parameter(request, "name"), batch, *length);
        }
    } catch (const UploadError& error) {
        if (error.status == too_large) {
            (void)answer_upload(connection, error);
            return -1;  // Not worth waiting for; anything smaller is read, so that browsers listen.
        }
        upload.error = error;
    }
    uploading_[connection] = std::move(upload);
    return *length == 0 ? end_upload(connection) : 0;
}

int Loop::end_upload(lws* connection) {
    auto node = uploading_.extract(connection);
    if (node.empty()) {
        return 0;
    }
    Upload upload = std::move(node.mapped());
    try {
        if (upload.files) {
            upload.files->finish();
        } else if (!upload.error) {
            upload.file->finish();
        }
    } catch (const UploadError& error) {
        upload.error = error;
    }
    if (upload.error) {
        return answer_upload(connection, *upload.error);
    }
    return answer(connection, 200, json_type, "{}");
}

int Loop::end_batch(lws* connection, const Request& request) {
    try {
        const UploadedBatch batch = uploads_.done(parameter(request, "batch"));
        return answer(
            connection, 200, json_type,
            json_text(
                {{"path", batch.path.string()}, {"name", batch.name}, {"files", batch.files}}));
    } catch (const UploadError& error) {
        return answer_upload(connection, error);
    }
}

}  // namespace pxpl5::host::serve
