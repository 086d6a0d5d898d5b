#include "host/serve/server/server_loop.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <libwebsockets.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include "host/base/error.hpp"

namespace pxpl5::host::serve {
namespace {

constexpr unsigned max_connections = 256;
constexpr std::size_t chunk_bytes = 64U << 10U;  // Of uploads and files.
constexpr unsigned short max_header_bytes = 8192;
constexpr unsigned short max_headers_at_once = 64;

// Sent with every answer.
const lws_protocol_vhost_options no_referrer{nullptr, nullptr, "referrer-policy:", "no-referrer"};
const lws_protocol_vhost_options no_frame{&no_referrer, nullptr, "x-frame-options:", "deny"};
const lws_protocol_vhost_options own_resources{&no_frame, nullptr,
                                               "cross-origin-resource-policy:", "same-origin"};
const lws_protocol_vhost_options own_window{&own_resources, nullptr,
                                            "cross-origin-opener-policy:", "same-origin"};
const lws_protocol_vhost_options no_sniff{&own_window, nullptr,
                                          "x-content-type-options:", "nosniff"};
const lws_protocol_vhost_options policy{
    &no_sniff, nullptr, "content-security-policy:",
    "default-src 'self'; img-src 'self' blob: data:; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'"};

/// Messages of libwebsockets during its start; null afterwards.
thread_local std::string* complaints = nullptr;

void complain(int /*level*/, const char* line) {
    if (complaints != nullptr) {
        *complaints += line;
    }
}

int call_loop(lws* connection, lws_callback_reasons reason, void* /*user*/, void* data,
              std::size_t size) {
    lws_context* context = lws_get_context(connection);
    auto* loop = context == nullptr ? nullptr : static_cast<Loop*>(lws_context_user(context));
    return loop == nullptr ? 0 : loop->on_event(connection, reason, data, size);
}

const std::array<lws_protocols, 2> protocols{
    {{"pxpl5", call_loop, 0, chunk_bytes, 0, nullptr, 0}, {nullptr, nullptr, 0, 0, 0, nullptr, 0}}};

bool is_ipv6(const std::string& address) {
    return address.find(':') != std::string::npos;
}

void check_address(const std::string& bind) {
    std::array<unsigned char, sizeof(in6_addr)> ignored{};
    if (inet_pton(is_ipv6(bind) ? AF_INET6 : AF_INET, bind.c_str(), ignored.data()) != 1) {
        throw RequestError(
            ExitCode::usage,
            fmt::format("--bind takes an address such as 127.0.0.1 or 0.0.0.0, not '{}'", bind));
    }
}

void check_options(const ServerOptions& options) {
    check_address(options.bind);
    constexpr int max_port = 65535;
    if (options.port < 0 || options.port > max_port) {
        throw RequestError(ExitCode::usage,
                           fmt::format("--port takes 0 to {}, not {}", max_port, options.port));
    }
    if (options.tls_cert.empty() != options.tls_key.empty()) {
        throw RequestError(ExitCode::usage, "--tls-cert and --tls-key must be given together");
    }
    if (!is_loopback(options.bind) && options.tls_cert.empty() && !options.insecure) {
        throw RequestError(
            ExitCode::usage,
            fmt::format("--bind {} lets others listen in: give --tls-cert and --tls-key, or "
                        "--insecure if the network is trusted",
                        options.bind));
    }
    for (const std::string& file : {options.tls_cert, options.tls_key}) {
        if (!file.empty() && access(file.c_str(), R_OK) != 0) {
            throw RequestError(ExitCode::bad_data,
                               fmt::format("cannot read {}: {}", file, std::strerror(errno)));
        }
    }
}

RequestError cannot_listen(const ServerOptions& options, const std::string& reason) {
    return {ExitCode::unavailable,
            fmt::format("cannot listen on {} port {}: {}", options.bind, options.port, reason)};
}

/// Binds for a moment: libwebsockets would name no reason, and leak when it fails.
void check_can_bind(const ServerOptions& options) {
    sockaddr_in v4{};
    sockaddr_in6 v6{};
    v4.sin_family = AF_INET;
    v6.sin6_family = AF_INET6;
    v4.sin_port = v6.sin6_port = htons(static_cast<std::uint16_t>(options.port));
    const bool six = is_ipv6(options.bind);
    void* place = six ? static_cast<void*>(&v6.sin6_addr) : &v4.sin_addr;
    inet_pton(six ? AF_INET6 : AF_INET, options.bind.c_str(), place);
    const int fd = socket(six ? AF_INET6 : AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (fd < 0) {
        throw cannot_listen(options, std::strerror(errno));
    }
    const auto* address =
        six ? reinterpret_cast<const sockaddr*>(&v6) : reinterpret_cast<const sockaddr*>(&v4);
    const int reuse = 1;  // As libwebsockets does: connections of a server before may linger.
    setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &reuse, sizeof(reuse));
    const bool bound = bind(fd, address, six ? sizeof(v6) : sizeof(v4)) == 0;
    const std::string reason = bound ? "" : std::strerror(errno);
    close(fd);
    if (!bound) {
        throw cannot_listen(options, reason);
    }
}

/// The name in the certificate: browsers accept the certificate for this name only.
std::string certificate_name(lws_vhost* vhost) {
    union {
        lws_tls_cert_info_results info;
        std::array<char, 512> room;  // The name may run on past the struct's own field.
    } results{};
    const std::size_t size = results.room.size() - sizeof(results.info) + sizeof(results.info.ns);
    const int failed =
        lws_tls_vhost_cert_info(vhost, LWS_TLS_CERT_INFO_COMMON_NAME, &results.info, size);
    return failed != 0 ? "" : std::string(results.info.ns.name);
}

void make_folder(const std::filesystem::path& folder) {
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error) {
        throw RequestError(ExitCode::failed, fmt::format("cannot make the folder '{}': {}",
                                                         folder.string(), error.message()));
    }
}

RouteFolders folders_of(const ServerOptions& options) {
    RouteFolders folders = built_in_folders();
    if (!options.page.empty()) {
        folders.page = options.page;
    }
    folders.downloads = options.downloads;
    return folders;
}

}  // namespace

Loop::Loop(const ServerOptions& options, Mail& mail)
    : mail_(mail), routes_(folders_of(options)), uploads_(options.uploads) {
    check_options(options);
    make_folder(options.uploads);
    make_folder(options.downloads);
    rules_.driver_token = random_token();
    rules_.watcher_token = random_token();
    rules_.driver_session = random_token();
    rules_.watcher_session = random_token();
    rules_.names = reachable_names(options.bind);
    rules_.encrypted = !options.tls_cert.empty();
    allow_hosts(rules_, options.allowed_hosts);
    listen(options);
    rules_.cookie_name = fmt::format("pxpl5_{}", port_);
}

Loop::~Loop() {
    lws_context_destroy(context_);
}

void Loop::listen(const ServerOptions& options) {
    check_can_bind(options);
    lws_context_creation_info info{};
    info.port = options.port;
    info.iface = options.bind.c_str();
    info.protocols = protocols.data();
    info.headers = &policy;
    info.user = this;
    info.options = LWS_SERVER_OPTION_FAIL_UPON_UNABLE_TO_BIND | LWS_SERVER_OPTION_VALIDATE_UTF8;
    if (!is_ipv6(options.bind)) {
        info.options |= LWS_SERVER_OPTION_DISABLE_IPV6;
    }
    info.fd_limit_per_thread = max_connections;
    info.pt_serv_buf_size = chunk_bytes;
    info.max_http_header_data = max_header_bytes;
    info.max_http_header_pool = max_headers_at_once;
    info.alpn = "http/1.1";
    if (rules_.encrypted) {
        info.options |= LWS_SERVER_OPTION_DO_SSL_GLOBAL_INIT;
        info.ssl_cert_filepath = options.tls_cert.c_str();
        info.ssl_private_key_filepath = options.tls_key.c_str();
        // Of TLS 1.2 only what keeps recorded traffic secret after the key is known. TLS 1.3 has
        // no other suites.
        info.ssl_cipher_list = "ECDHE+AESGCM:ECDHE+CHACHA20";
    }
    std::string log;
    complaints = &log;
    lws_set_log_level(LLL_ERR, complain);
    context_ = lws_create_context(&info);
    complaints = nullptr;
    lws_vhost* vhost = context_ == nullptr ? nullptr : lws_get_vhost_by_name(context_, "default");
    port_ = vhost == nullptr ? 0 : lws_get_vhost_listen_port(vhost);
    if (port_ > 0) {
        if (rules_.encrypted) {
            rules_.names.push_back(certificate_name(vhost));
        }
        return;
    }
    if (context_ != nullptr) {
        lws_context_destroy(context_);
    }
    if (rules_.encrypted) {  // The address was free.
        throw RequestError(
            ExitCode::bad_data,
            fmt::format("the certificate {} and the key {} cannot be used: {}. Both "
                        "must be PEM files, and the key that of the certificate",
                        options.tls_cert, options.tls_key, log.substr(0, log.find('\n'))));
    }
    throw cannot_listen(options, log);
}

void Loop::run() {
    // Without an end of its own: libwebsockets sleeps until a connection, a timer or wake().
    while (!stopping_ && lws_service(context_, 0) >= 0) {
    }
    if (!stopping_) {
        mail_.push(Lost{"the web server cannot go on: its service of connections has failed"});
    }
}

void Loop::wake() {
    lws_cancel_service(context_);
}

void Loop::stop() {
    stopping_ = true;
    wake();
}

int Loop::on_event(lws* connection, int reason, void* data, std::size_t size) {
    const std::string_view bytes(static_cast<const char*>(data), data == nullptr ? 0 : size);
    // Nothing may be thrown through libwebsockets: a connection that cannot be served is closed.
    try {
        if (reason == LWS_CALLBACK_EVENT_WAIT_CANCELLED) {
            deliver();
            return 0;
        }
        if (reason == LWS_CALLBACK_SERVER_NEW_CLIENT_INSTANTIATED) {
            meet(connection);
            return 0;
        }
        if (reason == LWS_CALLBACK_TIMER && is_stranger(connection)) {
            return -1;
        }
        if (reason == LWS_CALLBACK_WSI_DESTROY) {
            forget(connection);
            return 0;
        }
        const int socket = on_socket_event(connection, reason, bytes);
        return socket != 0 ? socket : on_http_event(connection, reason, bytes);
    } catch (const std::exception&) {
        return -1;
    }
}

void Loop::deliver() {
    for (const std::string& path : mail_.collect_opened()) {
        uploads_.opened(path);
    }
    for (const Outgoing& message : mail_.collect()) {
        for (auto& [connection, socket] : sockets_) {
            if (!socket.joined || socket.viewer.closing.code != 0 ||
                (message.viewer != 0 && message.viewer != socket.viewer.number)) {
                continue;
            }
            socket.viewer.line_up(message);
            lws_callback_on_writable(connection);
            if (socket.viewer.closing.code != 0) {
                close_soon(connection);
            }
        }
    }
    const auto newest = mail_.newest();
    if (newest->shown.rests) {
        resting_pixels_ = newest->shown.pixels->size();
    }
    for (auto& [connection, socket] : sockets_) {
        if (socket.viewer.takes(*newest)) {
            lws_callback_on_writable(connection);
        }
    }
    advise();
}

void Loop::advise() {
    const auto newest = mail_.newest();
    bool wanted = false;
    LinkAdvice advice;
    for (auto& [connection, socket] : sockets_) {
        if (!socket.joined) {
            continue;
        }
        wanted = wanted || socket.viewer.wants_newer(*newest);
        if (socket.viewer.role == Role::driver && resting_pixels_ > 0) {
            advice.scale = std::min(advice.scale, socket.viewer.link.scale(resting_pixels_));
        }
    }
    mail_.advise(wanted, newest->sequence, advice);
}

}  // namespace pxpl5::host::serve
