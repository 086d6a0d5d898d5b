// Messages between the computers of a machine.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/session/activity/activity.hpp"

namespace pxpl5::host {

struct ComputerReport {
    std::string name;
    int nodes = 0;
    double cpu_ms = 0;                 ///< Processor time of its nodes.
    std::uint64_t sent_bytes = 0;      ///< Bodies to other computers.
    std::uint64_t received_bytes = 0;  ///< Bodies from other computers.
};

/// Bodies of messages between computers. Bodies within a computer stay in shared memory.
struct NetworkReport {
    std::vector<ComputerReport> computers;  ///< In the order of their first nodes.
    struct Kind {
        bus::Body kind = bus::Body::NONE;
        std::uint64_t bytes = 0;
    };
    std::vector<Kind> kinds;  ///< Most bytes first.
    std::uint64_t bytes = 0;
};

/// Sums up the nodes of a report. No computers if all nodes are on one that has no name.
NetworkReport network_of(const ActivityReport& report);

}  // namespace pxpl5::host
