// The main of a node process: joins the machine, drives a Node until Shutdown, reports faults.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "ringbus/node.hpp"

namespace pxpl5::bus {

using NodeFactory = std::function<std::unique_ptr<Node>()>;

/// What a launcher says to a child on its command line.
struct ProcessFlags {
    std::string host_endpoint;  ///< --host-endpoint: where the host listens.
    std::string bind;           ///< --bind: where this node shall listen.
    NodeId node_id = 0;         ///< --node-id: its number on the ring, 1 or more.
    std::uint16_t index = 0;    ///< --index: counts from 0 within the role.
    int parent_pid = 0;         ///< --parent-pid: ends when that process is no longer its parent.
    schema::Recording record = schema::Recording::off;  ///< --record: off, flight or full.
    std::string trace_file{};                           ///< --trace-file: where to; then needed.
    int flight_kib = 1 << 16;  ///< --flight-kib: share of the machine's flight recording, in KiB.
};

/// The flags as a command line that parse_flags reads back.
std::vector<std::string> to_arguments(const ProcessFlags& flags);

/// Unknown flags are left to the program's own main. Throws std::invalid_argument naming the flag.
ProcessFlags parse_flags(int argc, char** argv);

/// What host and children must agree on: "pxpl5 <version>, protocol <n>".
std::string build_id();

/// Empty if the child that says `hello` is of this build, else what differs, with both values.
std::string refuse_hello(const schema::Hello& hello);

/// Told of every received message, in order: whether the node's trace shall do without it.
using LeaveOut = std::function<bool(const Message&)>;

/// Parses the flags above and --version, joins the machine as `role`, and drives the node until the
/// host says Shutdown or dies. Messages that come between Topology and Go are kept for the node.
///
/// Returns   the exit code: 0 after Shutdown, 64 for a bad command line, 69 if the host is gone,
///           70 for an internal error.
int run_process(int argc, char** argv, schema::Role role, const NodeFactory& make_node,
                const LeaveOut& leave_out = {});

}  // namespace pxpl5::bus
