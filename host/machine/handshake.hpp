// The host's side of the start: Hello from all, topology to all, Connected from all, Go to all.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/machine/roster.hpp"
#include "ringbus/message.hpp"

namespace pxpl5::host {

/// Values that must be equal in host and child.
struct Identity {
    std::string build;
    std::uint64_t schema_hash = 0;
};

/// Records which nodes have sent Hello and Connected.
class Handshake {
  public:
    /// nodes   Without the host; their pids are known.
    Handshake(Roster nodes, Identity own);

    /// Stores the endpoint of node `id`. Throws MachineError (69) if the node was not started, has
    /// sent Hello before, says that it is another node, or has another build or schema. The error
    /// names the node and both values.
    void hello(bus::NodeId id, const bus::schema::Hello& hello);
    /// Records that `id` knows all others. Throws MachineError (69) if `id` is unknown.
    void connected(bus::NodeId id);

    /// Names of the nodes that have not sent Hello, or Connected.
    std::vector<std::string> without_hello() const;
    std::vector<std::string> unconnected() const;

    /// The nodes with their endpoints.
    const Roster& nodes() const { return nodes_; }

  private:
    Roster nodes_;
    Identity own_;
    std::vector<bool> connected_;
};

}  // namespace pxpl5::host
