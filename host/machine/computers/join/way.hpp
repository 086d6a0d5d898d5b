// The way from a computer to a host, which may start later.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "host/machine/port.hpp"
#include "host/machine/processes/supervisor.hpp"

namespace pxpl5::host {

/// Begin of an address.
inline constexpr std::string_view tcp = "tcp://";

/// The addresses of a host, with one port.
struct Addresses {
    std::vector<std::string> hosts;  ///< IPv4 addresses or names.
    int port = 0;
};

/// Reads "tcp://10.0.0.1:4711,tcp://192.168.1.1:4711" or "tcp://pxpl5-host:4711". Throws
/// RequestError (usage).
Addresses parse_addresses(const std::string& text);

/// A way from this computer to a host.
struct Way {
    std::string address;  ///< "tcp://10.0.0.1:4711": the first that answered.
    std::string own;      ///< This computer's IPv4 address on the same way.
};

/// The end of `pxpl5 join` by a signal before it takes part in a machine.
MachineError join_interruption(int signal);

/// Tries all addresses at the same time, and again until one answers. Names are looked up each
/// time: a name may become known later, and may change its address.
///
/// end_ms  On the clock of now_ms(). One look takes up to 2 s longer.
/// say     Gets a line for the user when the reason to wait changes.
/// Throws RequestError (unavailable) with the last reason at `end_ms`, and MachineError after a
/// signal.
Way await_way(const std::string& addresses, std::int64_t end_ms, Supervisor& supervisor,
              const std::function<void(const std::string&)>& say);

}  // namespace pxpl5::host
