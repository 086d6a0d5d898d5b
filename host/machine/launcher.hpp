// Brings the processes of a machine up, watches them, and brings them down.
#pragma once

#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "host/machine/handshake.hpp"
#include "host/machine/machine.hpp"
#include "host/machine/port.hpp"
#include "host/machine/roster.hpp"
#include "host/machine/run_folder.hpp"
#include "host/machine/supervisor.hpp"
#include "ringbus/zmq_link.hpp"

namespace pxpl5::host {

/// What Machine is made of. Every failure ends the machine first and is thrown then.
class Launcher {
  public:
    /// Prepares folders and the host's own address; starts nothing.
    Launcher(const Topology& topology, const MachineOptions& options);

    /// Starts all nodes and takes them through the barriers. Throws MachineError.
    void launch();

    /// Starts one more process, which knows the host alone. Throws RequestError if it ends early,
    /// MachineError as check_health().
    bus::NodeId start_io();
    /// Tells it to end; it goes on its own, and is killed if it is still there at the next one.
    void release_io();

    /// The next message, if one is here; never one of the handshake. Throws MachineError.
    std::optional<bus::Message> receive();
    void send(bus::NodeId to, bus::Payload payload);
    /// Waits for a message or for something that check_health() tells of.
    void wait();

    /// Throws MachineError if a node has died or a signal came, RequestError (bad data) if the io
    /// process has died.
    void check_health();

    /// Orderly end. Throws MachineError if a node does not end by itself, or not with 0.
    void shutdown();

    const Roster& roster() const { return roster_; }
    const std::filesystem::path& folder() const { return folder_; }
    std::string name_of(bus::NodeId id) const;

  private:
    void spawn(RosterEntry& node, const RoleSettings& settings, std::vector<std::string> arguments);
    /// The barriers, for `nodes`, which are started: Hello, topology, connected, Go.
    Roster bring_up(Roster nodes);
    using Missing = std::function<std::vector<std::string>()>;
    void await(const std::string& what, Handshake& handshake, const Missing& missing);
    void take_control(const bus::Message& message, Handshake& handshake);
    std::optional<bus::Message> take_from_link();
    /// Forgets io processes that have ended; kills those that have not.
    void bury_dismissed();
    void dismiss_io();
    std::string describe(const Death& death) const;
    [[noreturn]] void fail(int code, const std::string& text);
    /// Ends everyone. Returns the first death that was not an orderly one.
    std::optional<Death> bring_down(int grace_ms);
    void discard_messages();

    Topology topology_;
    MachineOptions options_;
    std::filesystem::path folder_;
    SocketFolder sockets_;
    bus::ZmqLink link_;
    Supervisor supervisor_;  // Behind the link: children end before the socket that they know.
    Roster roster_;          ///< Host first.
    std::optional<RosterEntry> io_;
    int io_count_ = 0;
    bool launched_ = false;                         ///< All nodes have been told Go.
    std::map<bus::NodeId, std::string> dismissed_;  ///< io processes of the past, by name.
    std::deque<bus::Message> backlog_;              ///< Came while a handshake was going on.
    std::optional<MachineError> over_;              ///< Why nothing works any more.
};

}  // namespace pxpl5::host
