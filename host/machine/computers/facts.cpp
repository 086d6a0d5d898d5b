#include "host/machine/computers/facts.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <poll.h>
#include <sched.h>
#include <sys/socket.h>
#include <sys/sysinfo.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <climits>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string_view>

#include "host/base/error.hpp"
#include "host/machine/computers/cluster_settings.hpp"
#include "host/machine/supervisor.hpp"

namespace pxpl5::host {

namespace {

std::string first_line(const char* path) {
    std::ifstream file(path);
    std::string line;
    std::getline(file, line);
    return line;
}

/// "pid:[4026531836]"
std::string name_space(const char* kind) {
    std::error_code error;
    return std::filesystem::read_symlink(fmt::format("/proc/self/ns/{}", kind), error).string();
}

std::string variable(const char* name) {
    const char* text = std::getenv(name);
    return text == nullptr ? "" : text;
}

std::string job_of_engine() {
    if (const std::string job = variable("SLURM_JOB_ID"); !job.empty()) {
        return fmt::format("slurm {}.{}", job, variable("SLURM_STEP_ID"));
    }
    if (const std::string job = variable("OMPI_COMM_WORLD_RANK"); !job.empty()) {
        return fmt::format("mpirun {}", job);
    }
    return {};
}

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

/// A socket that connects; null if there is no way at all.
std::unique_ptr<Socket> begin_connecting(const std::string& address, int port) {
    auto socket =
        std::make_unique<Socket>(::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<std::uint16_t>(port));
    if (inet_pton(AF_INET, address.c_str(), &to.sin_addr) != 1) {
        return nullptr;
    }
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

}  // namespace

join::FactsT own_facts() {
    join::FactsT facts;
    std::array<char, HOST_NAME_MAX + 1> name{};
    gethostname(name.data(), HOST_NAME_MAX);
    // The name that Slurm knows may differ from the computer's own.
    const std::string known = variable("SLURMD_NODENAME");
    facts.name = known.empty() ? name.data() : known;
    cpu_set_t cores;
    facts.cores = static_cast<std::uint16_t>(
        sched_getaffinity(0, sizeof cores, &cores) == 0 ? CPU_COUNT(&cores) : 1);
    struct sysinfo system {};
    sysinfo(&system);
    facts.memory_bytes = std::uint64_t{system.totalram} * system.mem_unit;
    facts.place = fmt::format("{} {} {} user {}", first_line("/proc/sys/kernel/random/boot_id"),
                              name_space("pid"), name_space("mnt"), getuid());
    facts.pid = static_cast<std::uint32_t>(getpid());
    facts.job = job_of_engine();
    return facts;
}

std::vector<std::string> own_addresses() {
    std::vector<std::string> addresses;
    ifaddrs* list = nullptr;
    if (getifaddrs(&list) != 0) {
        return addresses;
    }
    const std::unique_ptr<ifaddrs, decltype(&freeifaddrs)> owner(list, &freeifaddrs);
    for (const ifaddrs* each = list; each != nullptr; each = each->ifa_next) {
        const bool is_usable = each->ifa_addr != nullptr && each->ifa_addr->sa_family == AF_INET &&
                               (each->ifa_flags & IFF_UP) != 0 &&
                               (each->ifa_flags & IFF_LOOPBACK) == 0;
        if (is_usable) {
            addresses.push_back(
                text_of(reinterpret_cast<const sockaddr_in*>(each->ifa_addr)->sin_addr));
        }
    }
    return addresses;
}

Addresses parse_addresses(const std::string& text) {
    Addresses addresses;
    for (const std::string& each : words_of(text)) {
        const std::size_t colon = each.rfind(':');
        int port = 0;
        const bool has_port =
            each.starts_with(tcp) && colon != std::string::npos && colon > tcp.size() &&
            std::from_chars(&each[colon] + 1, each.data() + each.size(), port).ec == std::errc{};
        if (!has_port || port < 1 || port > 65535 ||
            (addresses.port != 0 && port != addresses.port)) {
            throw RequestError(ExitCode::usage,
                               fmt::format("join: '{}' is no address of a host; pxpl5 prints it as "
                                           "tcp://10.0.0.1:4711, several with commas, one port",
                                           each));
        }
        addresses.port = port;
        addresses.hosts.emplace_back(each.substr(tcp.size(), colon - tcp.size()));
        check_ipv4("the address of the host", addresses.hosts.back());
    }
    return addresses;
}

std::optional<Way> find_way(const std::vector<std::string>& addresses, int port, int limit_ms) {
    std::vector<std::unique_ptr<Socket>> sockets;
    std::vector<pollfd> polled;
    for (const std::string& address : addresses) {
        sockets.push_back(begin_connecting(address, port));
        polled.push_back({sockets.back() ? sockets.back()->fd : -1, POLLOUT, 0});
    }
    const std::int64_t end_ms = now_ms() + limit_ms;
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
                return Way{addresses[i], *own};
            }
            polled[i].fd = -1;  // Refused, or no way.
        }
    }
    return std::nullopt;
}

}  // namespace pxpl5::host
