// The nodes of a machine, each with id, name and address.
#pragma once

#include <string>
#include <vector>

#include "host/machine/port.hpp"
#include "host/machine/topology.hpp"
#include "ringbus/message.hpp"

namespace pxpl5::host {

struct RosterEntry {
    bus::NodeId id = 0;
    bus::schema::Role role = bus::schema::Role::host;
    int index = 0;         ///< Within the role.
    std::string endpoint;  ///< Empty before its Hello.
    int pid = 0;           ///< 0 before its start, and before its Hello on another computer.
    std::string near_endpoint = {};  ///< For nodes on the same computer; empty: `endpoint`.
    int computer = 0;                ///< 0: the host's own, else as RemoteComputers counts.
    int place = 0;  ///< Equal for nodes that share memory and sockets; 0: with the host.

    std::string name() const;    ///< "gp-3"; also names its log and its socket.
    std::string binary() const;  ///< "pxpl5-gp"; empty for the host.
};
using Roster = std::vector<RosterEntry>;

/// The nodes in ring order: the host (id 0), the GPs, the Renderers, the frame buffers. Ids ascend.
Roster roster_of(const Topology& topology);

/// The nodes of `role`, by index.
std::vector<bus::NodeId> ids_of(const Roster& roster, bus::schema::Role role);

/// All nodes, in the form that a session uses.
std::vector<MachineNode> nodes_of(const Roster& roster);

/// The message that describes the machine to every node.
bus::Payload topology_message(const Roster& roster, const Topology& topology);

/// The settings of a role that is launched. `role` is gp, renderer or frame_buffer.
const RoleSettings& settings_of(const Topology& topology, bus::schema::Role role);

/// The order to end.
bus::Payload shutdown_message();

}  // namespace pxpl5::host
