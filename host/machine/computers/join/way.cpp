#include "host/machine/computers/join/way.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <future>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "host/base/error.hpp"
#include "host/base/kernel/answer_within.hpp"
#include "host/machine/computers/cluster_settings.hpp"

namespace pxpl5::host {

namespace {

constexpr std::int64_t try_ms = 2000;   // For the names of one look, and for its connections.
constexpr std::int64_t pause_ms = 500;  // Between two looks.
constexpr int max_port = 65535;

struct Socket {
    int fd = -1;
    explicit Socket(int opened) : fd(opened) {}
    ~Socket() { close(fd); }
    Socket(const Socket&) = delete;
    Socket& operator=(const Socket&) = delete;
};

std::string text_of(const in_addr& address) {
    std::array<char, INET_ADDRSTRLEN> text{};
    inet_ntop(AF_INET, &address, text.data(), text.size());
    return text.data();
}

bool is_ipv4(const std::string& text) {
    in_addr address{};
    return inet_pton(AF_INET, text.c_str(), &address) == 1;
}

/// The addresses of a name, or the reason why there are none.
struct LookedUp {
    std::vector<std::string> addresses;
    std::string reason;
};

LookedUp look_up_now(const std::string& name) {
    addrinfo wanted{};
    wanted.ai_family = AF_INET;
    wanted.ai_socktype = SOCK_STREAM;
    addrinfo* list = nullptr;
    if (const int error = getaddrinfo(name.c_str(), nullptr, &wanted, &list); error != 0) {
        return {{}, fmt::format("the name {} is not known: {}", name, gai_strerror(error))};
    }
    const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> owner(list, &freeaddrinfo);
    LookedUp found;
    for (const addrinfo* each = list; each != nullptr; each = each->ai_next) {
        found.addresses.push_back(
            text_of(reinterpret_cast<const sockaddr_in*>(each->ai_addr)->sin_addr));
    }
    return found;
}

/// Looks up names. A name service may take long, so each name has at most one question under way.
class Names {
  public:
    /// The addresses of `host`, which is an address or a name. An answer that takes longer than
    /// `limit_ms` is taken by a later call.
    LookedUp look_up(const std::string& host, std::int64_t limit_ms) {
        if (is_ipv4(host)) {
            return {{host}, {}};
        }
        std::future<LookedUp>& answer = answers_[host];
        if (!answer.valid()) {
            answer = begin_answer([host] { return look_up_now(host); });
        }
        if (answer.wait_for(std::chrono::milliseconds(limit_ms)) != std::future_status::ready) {
            return {{}, fmt::format("the name service does not answer for {}", host)};
        }
        return answer.get();  // The next call asks again.
    }

  private:
    std::map<std::string, std::future<LookedUp>> answers_;
};

/// A socket that connects; null if there is no way at all.
std::unique_ptr<Socket> begin_connecting(const std::string& address, int port) {
    auto socket =
        std::make_unique<Socket>(::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<std::uint16_t>(port));
    inet_pton(AF_INET, address.c_str(), &to.sin_addr);
    const int result = connect(socket->fd, reinterpret_cast<const sockaddr*>(&to), sizeof to);
    return result == 0 || errno == EINPROGRESS ? std::move(socket) : nullptr;
}

/// The own end of a connected socket; nothing if it has not connected.
std::optional<std::string> own_end(int fd) {
    int error = 0;
    socklen_t size = sizeof error;
    sockaddr_in own{};
    socklen_t own_size = sizeof own;
    if (getsockopt(fd, SOL_SOCKET, SO_ERROR, &error, &size) != 0 || error != 0 ||
        getsockname(fd, reinterpret_cast<sockaddr*>(&own), &own_size) != 0) {
        return std::nullopt;
    }
    return text_of(own.sin_addr);
}

/// Connects to `port` at all `addresses` at the same time, and returns the first that answers;
/// nothing if none has answered until `end_ms`.
std::optional<Way> find_way(const std::vector<std::string>& addresses, int port,
                            std::int64_t end_ms) {
    std::vector<std::unique_ptr<Socket>> sockets;
    std::vector<pollfd> polled;
    for (const std::string& address : addresses) {
        sockets.push_back(begin_connecting(address, port));
        polled.push_back({sockets.back() ? sockets.back()->fd : -1, POLLOUT, 0});
    }
    const auto is_open = [](const pollfd& each) { return each.fd >= 0; };
    while (std::ranges::any_of(polled, is_open)) {
        const std::int64_t left_ms = std::max<std::int64_t>(end_ms - now_ms(), 0);
        const int ready = poll(polled.data(), polled.size(), static_cast<int>(left_ms));
        if (ready == 0 || (ready < 0 && errno != EINTR)) {
            break;
        }
        for (std::size_t i = 0; i < polled.size(); ++i) {
            if (polled[i].fd < 0 || polled[i].revents == 0) {
                continue;
            }
            if (const auto own = own_end(polled[i].fd)) {
                return Way{fmt::format("{}{}:{}", tcp, addresses[i], port), *own};
            }
            polled[i].fd = -1;  // Refused, or no way.
        }
    }
    return std::nullopt;
}

/// One look at all addresses. `reason` says why there is no way. A slow name service leaves the
/// whole limit for the connections.
std::optional<Way> look(const Addresses& to, Names& names, std::string& reason) {
    std::vector<std::string> addresses, hosts = to.hosts;
    std::ranges::stable_partition(hosts, is_ipv4);  // They need no name service.
    reason.clear();
    const std::int64_t end_ms = now_ms() + try_ms;
    for (const std::string& host : hosts) {
        const LookedUp found = names.look_up(host, std::max<std::int64_t>(end_ms - now_ms(), 0));
        addresses.insert(addresses.end(), found.addresses.begin(), found.addresses.end());
        reason = reason.empty() ? found.reason : reason;
    }
    if (reason.empty()) {
        reason =
            fmt::format("no program listens at port {} of {}", to.port, fmt::join(addresses, ", "));
    }
    return find_way(addresses, to.port, now_ms() + try_ms);
}

}  // namespace

Addresses parse_addresses(const std::string& text) {
    Addresses addresses;
    for (const std::string& each : words_of(text)) {
        const std::size_t colon = each.rfind(':');
        int port = 0;
        const bool has_port =
            each.starts_with(tcp) && colon != std::string::npos && colon > tcp.size() &&
            std::from_chars(&each[colon] + 1, each.data() + each.size(), port).ec == std::errc{};
        if (!has_port || port < 1 || port > max_port ||
            (addresses.port != 0 && port != addresses.port)) {
            throw RequestError(ExitCode::usage,
                               fmt::format("join: '{}' is no address of a host; pxpl5 prints it as "
                                           "tcp://10.0.0.1:4711, several with commas, one port",
                                           each));
        }
        addresses.port = port;
        addresses.hosts.emplace_back(each.substr(tcp.size(), colon - tcp.size()));
    }
    check_names(addresses.hosts, "join", "the address of the host");
    return addresses;
}

MachineError join_interruption(int signal) {
    MachineError error(128 + signal, "interrupted before the host answered");
    error.is_interruption = true;
    return error;
}

Way await_way(const std::string& addresses, std::int64_t end_ms, Supervisor& supervisor,
              const std::function<void(const std::string&)>& say) {
    const Addresses to = parse_addresses(addresses);
    const std::int64_t begin_ms = now_ms();
    std::string reason, said;
    Names names;
    for (;;) {
        if (const int signal = supervisor.take_interrupt(); signal != 0) {
            throw join_interruption(signal);
        }
        if (auto way = look(to, names, reason)) {
            return *way;
        }
        const std::int64_t left_ms = end_ms - now_ms();
        if (left_ms <= 0) {
            throw RequestError(
                ExitCode::unavailable,
                fmt::format("no host answers at {} within {} s: {}. Has its program ended, or does "
                            "a firewall close port {}?",
                            addresses, (end_ms - begin_ms + 999) / 1000, reason, to.port));
        }
        if (reason != said) {
            said = reason;
            say(fmt::format("waits for the host at {}, {} s more: {}", addresses,
                            (left_ms + 999) / 1000, reason));
        }
        supervisor.wait(-1, static_cast<int>(std::min(left_ms, pause_ms)));
    }
}

}  // namespace pxpl5::host
