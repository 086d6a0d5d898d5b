#include "host/serve/server/listener.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <libwebsockets.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

#include "host/base/error.hpp"
#include "host/base/part_file.hpp"

namespace pxpl5::host::serve {
namespace {

constexpr unsigned max_connections = 256;
constexpr std::size_t read_bytes = 64U << 10U;
constexpr unsigned short max_header_bytes = 8192;
constexpr unsigned short max_headers_at_once = 64;

// Sent with every answer, beside the content policy of the server's pages.
const lws_protocol_vhost_options no_referrer{nullptr, nullptr, "referrer-policy:", "no-referrer"};
const lws_protocol_vhost_options no_frame{&no_referrer, nullptr, "x-frame-options:", "deny"};
const lws_protocol_vhost_options own_resources{&no_frame, nullptr,
                                               "cross-origin-resource-policy:", "same-origin"};
const lws_protocol_vhost_options own_window{&own_resources, nullptr,
                                            "cross-origin-opener-policy:", "same-origin"};
const lws_protocol_vhost_options no_sniff{&own_window, nullptr,
                                          "x-content-type-options:", "nosniff"};
/// Messages of libwebsockets during its start; null afterwards.
thread_local std::string* complaints = nullptr;

void complain(int /*level*/, const char* line) {
    if (complaints != nullptr) {
        *complaints += line;
    }
}

bool is_ipv6(const std::string& address) {
    return address.find(':') != std::string::npos;
}

/// A name for the address that a browser can open.
std::string host_in_url(const std::string& bind) {
    if (bind == "0.0.0.0" || bind == "::") {
        std::array<char, 256> name{};
        return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "localhost";
    }
    return bind.find(':') == std::string::npos ? bind : "[" + bind + "]";
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
        // libwebsockets would open a FIFO, and wait for its other end without a limit.
        const std::string why = file.empty() ? "" : why_unreadable(file);
        if (!why.empty()) {
            throw RequestError(ExitCode::bad_data, fmt::format("cannot read {}: {}", file, why));
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

}  // namespace

Listener::Listener(const ServerOptions& options, const lws_protocols* protocols,
                   const char* content_policy, void* user)
    : policy_(std::make_unique<lws_protocol_vhost_options>(lws_protocol_vhost_options{
          &no_sniff, nullptr, "content-security-policy:", content_policy})) {
    check_options(options);
    rules_.driver_token = random_token();
    rules_.watcher_token = random_token();
    rules_.driver_session = random_token();
    rules_.watcher_session = random_token();
    rules_.names = reachable_names(options.bind);
    rules_.encrypted = !options.tls_cert.empty();
    allow_hosts(rules_, options.allowed_hosts);
    listen(options, protocols, user);
    rules_.cookie_name = fmt::format("pxpl5_{}", port_);
}

Listener::~Listener() {
    lws_context_destroy(context_);
}

std::string Listener::address() const {
    return fmt::format("{}://{}:{}/", rules_.encrypted ? "https" : "http", host_, port_);
}

void Listener::listen(const ServerOptions& options, const lws_protocols* protocols, void* user) {
    host_ = host_in_url(options.bind);
    check_can_bind(options);
    lws_context_creation_info info{};
    info.port = options.port;
    info.iface = options.bind.c_str();
    info.protocols = protocols;
    info.headers = policy_.get();
    info.user = user;
    info.options = LWS_SERVER_OPTION_FAIL_UPON_UNABLE_TO_BIND | LWS_SERVER_OPTION_VALIDATE_UTF8;
    if (!is_ipv6(options.bind)) {
        info.options |= LWS_SERVER_OPTION_DISABLE_IPV6;
    }
    info.fd_limit_per_thread = max_connections;
    info.pt_serv_buf_size = read_bytes;
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

}  // namespace pxpl5::host::serve
