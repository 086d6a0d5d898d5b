// Coming up, as the host sees it: all say Hello, all are told the topology, all connect, then Go.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/machine/roster.hpp"
#include "ringbus/message.hpp"

namespace pxpl5::host {

/// What host and child must agree on.
struct Identity {
    std::string build;
    std::uint64_t schema_hash = 0;
};

/// Which of `nodes` have said Hello, and which Connected.
class Handshake {
  public:
    /// nodes   Without the host; their pids are known.
    Handshake(Roster nodes, Identity own);

    /// Notes who can be reached where. Throws MachineError (69) for a node that was not started,
    /// said it before, or is of another build or schema: names the node and both values.
    void hello(const bus::schema::Hello& hello);
    /// Notes that `id` knows all others. Throws MachineError (69) if it is unknown.
    void connected(bus::NodeId id);

    /// Names of the nodes that have not said Hello, or not Connected.
    std::vector<std::string> without_hello() const;
    std::vector<std::string> unconnected() const;

    /// The nodes, with the endpoints that they said.
    const Roster& nodes() const { return nodes_; }

  private:
    Roster nodes_;
    Identity own_;
    std::vector<bool> connected_;
};

}  // namespace pxpl5::host
