// The main of a node process: joins the machine, drives a Node until Shutdown, reports faults.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "ringbus/node.hpp"

namespace pxpl5::bus {

using NodeFactory = std::function<std::unique_ptr<Node>()>;

/// Command line of a child process.
struct ProcessFlags {
    std::string host_endpoint;  ///< --host-endpoint: address of the host.
    std::string bind;           ///< --bind: address at which this node listens.
    NodeId node_id = 0;         ///< --node-id: number on the ring, 1 or more.
    std::uint16_t index = 0;    ///< --index: counts from 0 within the role.
    int parent_pid = 0;         ///< --parent-pid: the node ends when its parent is another process.
    Recording record = Recording::off;  ///< --record: off, flight or full.
    std::string trace_file{};           ///< --trace-file: file; required if recording is not off.
    int flight_kib = 1 << 16;  ///< --flight-kib: share of the machine's flight recording, in KiB.
    int pulse_fd = -1;         ///< --pulse-fd: descriptor of the pulse's cell; -1: no pulse.
    int pulse_ms = 1000;       ///< --pulse-ms: time between two beats.
    int credentials_fd = -1;   ///< --credentials-fd: open pipe with the machine's credentials.
    std::string near_bind{};   ///< --near-bind: another one, for nodes on the same computer.
    bool compress = false;     ///< --compress: messages to other computers are compressed.
};

/// Returns the flags as a command line for parse_flags().
std::vector<std::string> to_arguments(const ProcessFlags& flags);

/// Ignores unknown flags, which belong to the program's own main. Throws std::invalid_argument,
/// which names the flag.
ProcessFlags parse_flags(int argc, char** argv);

/// Returns "pxpl5 <version>, protocol <n>". The host and its children must have the same build id.
std::string build_id();

/// Returns "" if the child has this build, else a text with the difference and both values.
std::string refuse_hello(const schema::Hello& hello);

/// Called for every received message, in order. Returns true if the trace shall omit the message.
using LeaveOut = std::function<bool(const Message&)>;

/// Parses the flags above and --version, joins the machine as `role`, and drives the node until the
/// host sends Shutdown or dies. Messages between Topology and Go wait for the node.
///
/// Returns   the exit code: 0 after Shutdown, 64 for a bad command line, 69 if the host is gone,
///           70 for an internal error.
int run_process(int argc, char** argv, schema::Role role, const NodeFactory& make_node,
                const LeaveOut& leave_out = {});

}  // namespace pxpl5::bus
