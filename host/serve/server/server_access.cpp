#include "host/serve/server/server_access.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netdb.h>
#include <sys/random.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <memory>
#include <optional>

#include "host/base/error.hpp"
#include "host/base/kernel/answer_within.hpp"

namespace pxpl5::host::serve {
namespace {

std::string lower(std::string_view text) {
    std::string result(text);
    for (char& c : result) {
        c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    }
    return result;
}

/// The name of "name", "name:port" or "[address]:port".
std::string name_of(std::string_view host) {
    if (host.starts_with('[')) {
        const std::size_t end = host.find(']');
        return end == std::string_view::npos ? "" : lower(host.substr(1, end - 1));
    }
    return lower(host.substr(0, host.rfind(':')));
}

/// Takes as long for a nearly right guess as for a wrong one.
bool same_secret(std::string_view a, std::string_view b) {
    if (a.size() != b.size()) {
        return false;
    }
    unsigned difference = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        difference |= static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i]);
    }
    return difference == 0;
}

std::optional<Role> role_of(std::string_view secret, const std::string& drivers,
                            const std::string& watchers) {
    if (same_secret(secret, drivers)) {
        return Role::driver;
    }
    if (same_secret(secret, watchers)) {
        return Role::watcher;
    }
    return std::nullopt;
}

/// The value of cookie `name` in a Cookie header: "a=1; b=2".
std::string_view cookie_value(std::string_view cookies, std::string_view name) {
    while (!cookies.empty()) {
        const std::size_t end = std::min(cookies.find(';'), cookies.size());
        std::string_view pair = cookies.substr(0, end);
        cookies.remove_prefix(std::min(end + 1, cookies.size()));
        pair.remove_prefix(std::min(pair.find_first_not_of(' '), pair.size()));
        if (pair.size() > name.size() && pair.starts_with(name) && pair[name.size()] == '=') {
            return pair.substr(name.size() + 1);
        }
    }
    return {};
}

/// The origin as browsers name it: without the port of the scheme.
std::string origin_of(std::string_view scheme, std::string_view host, std::string_view port) {
    host.remove_suffix(host.ends_with(port) ? port.size() : 0);
    return fmt::format("{}{}", scheme, host);
}

/// A portal may encrypt what this server does not, and may name this server in the Host header.
bool is_portal(const AccessRules& rules, std::string_view origin) {
    return std::ranges::any_of(rules.portals, [&](const std::string& host) {
        return origin == origin_of("https://", host, ":443") ||
               origin == origin_of("http://", host, ":80");
    });
}

/// Checks where the request comes from; the reason, if that is not from here.
std::string foreign(const AccessRules& rules, const Request& request) {
    if (std::ranges::find(rules.names, name_of(request.host)) == rules.names.end()) {
        // The names stay unsaid: whoever asks may be a stranger.
        return fmt::format("Unknown host name '{}'. Open an address that pxpl5 serve printed.",
                           request.host);
    }
    const std::string here = (rules.encrypted ? "https://" : "http://") + lower(request.host);
    const std::string origin = lower(request.origin);
    if (!origin.empty() && origin != here && !is_portal(rules, origin)) {
        return fmt::format("A page from {} cannot use this server. Open {} instead.",
                           request.origin, here);
    }
    return "";
}

Verdict without_token() {
    return {403, "The token is missing. Open an address that pxpl5 serve printed.", {}, {}};
}

std::string host_name() {
    std::array<char, 256> name{};
    return gethostname(name.data(), name.size() - 1) == 0 ? lower(name.data()) : "";
}

constexpr int name_service_ms = 2000;

std::string full_name_now(const std::string& name) {
    addrinfo wanted{};
    wanted.ai_flags = AI_CANONNAME;
    addrinfo* raw = nullptr;
    if (getaddrinfo(name.c_str(), nullptr, &wanted, &raw) != 0) {
        return "";
    }
    const std::unique_ptr<addrinfo, void (*)(addrinfo*)> list(raw, freeaddrinfo);
    return list->ai_canonname == nullptr ? "" : lower(list->ai_canonname);
}

/// The name with its domain, by which a portal may know this computer; empty if it has none, or if
/// the name service does not answer.
std::string full_name(const std::string& name) {
    return answer_within(name_service_ms, [name] { return full_name_now(name); }).value_or("");
}

void add_interfaces(std::vector<std::string>& names) {
    ifaddrs* raw = nullptr;
    if (getifaddrs(&raw) != 0) {
        return;
    }
    const std::unique_ptr<ifaddrs, void (*)(ifaddrs*)> list(raw, freeifaddrs);
    for (const ifaddrs* at = raw; at != nullptr; at = at->ifa_next) {
        if (at->ifa_addr == nullptr) {
            continue;
        }
        const int family = at->ifa_addr->sa_family;
        if (family != AF_INET && family != AF_INET6) {
            continue;
        }
        const void* address =
            family == AF_INET ? static_cast<const void*>(
                                    &reinterpret_cast<const sockaddr_in*>(at->ifa_addr)->sin_addr)
                              : &reinterpret_cast<const sockaddr_in6*>(at->ifa_addr)->sin6_addr;
        std::array<char, INET6_ADDRSTRLEN> text{};
        if (inet_ntop(family, address, text.data(), text.size()) != nullptr) {
            names.emplace_back(text.data());
        }
    }
}

}  // namespace

Verdict judge(const AccessRules& rules, const Request& request) {
    if (request.host.empty()) {
        return {400, "The request has no Host header.", {}, {}};
    }
    if (std::string reason = foreign(rules, request); !reason.empty()) {
        return {403, std::move(reason), {}, {}};
    }
    const auto in_query = request.query.find("token");
    if (in_query != request.query.end()) {
        const auto role = role_of(in_query->second, rules.driver_token, rules.watcher_token);
        if (!role) {
            return {403, "The token is wrong. Open an address that pxpl5 serve printed.", {}, {}};
        }
        // Without a path: the cookie is for the page's folder as the browser sees it, which is a
        // prefix of its own behind a portal.
        std::string cookie =
            fmt::format("{}={}; HttpOnly; SameSite=Strict{}", rules.cookie_name,
                        *role == Role::driver ? rules.driver_session : rules.watcher_session,
                        rules.encrypted ? "; Secure" : "");
        return {200, "", *role, std::move(cookie), true};
    }
    const auto role = role_of(cookie_value(request.cookie, rules.cookie_name), rules.driver_session,
                              rules.watcher_session);
    if (!role) {
        return without_token();
    }
    return {200, "", *role, ""};
}

Verdict judge_by_token(const AccessRules& rules, const Request& request) {
    Verdict verdict = judge(rules, request);
    return verdict.status == 200 && !verdict.has_token ? without_token() : verdict;
}

void allow_hosts(AccessRules& rules, const std::vector<std::string>& hosts) {
    constexpr std::string_view letters =
        "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-._";
    constexpr std::string_view digits = "0123456789";
    for (const std::string& host : hosts) {
        const std::size_t name = std::min(host.find_first_not_of(letters), host.size());
        const std::string_view port = std::string_view(host).substr(name);
        const bool has_port = port.starts_with(':') && port.size() > 1 &&
                              port.find_first_not_of(digits, 1) == std::string_view::npos;
        if (name == 0 || (!port.empty() && !has_port)) {
            throw RequestError(
                ExitCode::usage,
                fmt::format("--allow-host '{}' is no host. Give the part of the portal's address "
                            "between // and /: portal.example.edu or portal.example.edu:8443",
                            host));
        }
        rules.portals.push_back(lower(host));
        rules.names.push_back(name_of(host));
    }
}

std::string random_token() {
    std::array<unsigned char, 16> bytes{};
    if (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) {
        throw RequestError(ExitCode::unavailable,
                           fmt::format("cannot make a token: {}", std::strerror(errno)));
    }
    return fmt::format("{:02x}", fmt::join(bytes, ""));
}

bool is_loopback(const std::string& address) {
    in_addr v4{};
    if (inet_pton(AF_INET, address.c_str(), &v4) == 1) {
        return (ntohl(v4.s_addr) >> 24U) == 127;
    }
    in6_addr v6{};
    return inet_pton(AF_INET6, address.c_str(), &v6) == 1 && IN6_IS_ADDR_LOOPBACK(&v6);
}

std::vector<std::string> reachable_names(const std::string& bind) {
    std::vector<std::string> names{"localhost", "127.0.0.1", "::1"};
    if (is_loopback(bind)) {
        names.push_back(bind);
    } else {
        names.push_back(host_name());
        names.push_back(full_name(names.back()));
        if (bind == "0.0.0.0" || bind == "::") {
            add_interfaces(names);
        } else {
            names.push_back(bind);
        }
    }
    std::ranges::sort(names);
    const auto doubled = std::ranges::unique(names);
    names.erase(doubled.begin(), doubled.end());
    std::erase(names, "");
    return names;
}

}  // namespace pxpl5::host::serve
