// Facts of a computer, and the addresses by which others reach it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "join_generated.h"

namespace pxpl5::host {

/// Begin of an address.
inline constexpr std::string_view tcp = "tcp://";

/// The facts of this computer. Addresses and folders are left to the caller.
join::FactsT own_facts();

/// The IPv4 addresses of this computer except for loopback, as the kernel lists them. The name of a
/// computer is never resolved to find its own addresses: on Debian it means 127.0.1.1.
std::vector<std::string> own_addresses();

/// The addresses of a host, with one port.
struct Addresses {
    std::vector<std::string> hosts;
    int port = 0;
};

/// Reads "tcp://10.0.0.1:4711,tcp://192.168.1.1:4711". Throws RequestError (usage).
Addresses parse_addresses(const std::string& text);

/// A way from this computer to another one.
struct Way {
    std::string address;  ///< The other computer's; the first that answered.
    std::string own;      ///< This computer's on the same way.
};

/// Connects to `port` at all `addresses` at the same time, and returns the first that answers;
/// nothing if none has answered within `limit_ms`.
std::optional<Way> find_way(const std::vector<std::string>& addresses, int port, int limit_ms);

}  // namespace pxpl5::host
