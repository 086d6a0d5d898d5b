// Facts of a computer, and its addresses.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "join_generated.h"
#include "ringbus/zmq/credentials.hpp"

namespace pxpl5::host {

/// The facts of this computer. Addresses and folders are left to the caller.
join::FactsT own_facts();

/// The first letter of this computer, with its facts. Addresses and folders are left to the caller.
///
/// name  For the host; empty: the name of this computer.
join::AskT own_question(const bus::Credentials& credentials, const std::string& name);

/// The IPv4 addresses of this computer except for loopback, as the kernel lists them. The name of a
/// computer is never resolved to find its own addresses: on Debian it means 127.0.1.1.
std::vector<std::string> own_addresses();

}  // namespace pxpl5::host
