// The machine as a session sees it: nodes to send to, and messages that come back.
#pragma once

#include <cstdint>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/base/error.hpp"
#include "ringbus/message.hpp"
#include "ringbus/traffic.hpp"

namespace pxpl5::host {

/// The machine has ended: a process died or could not start. `what` names the first cause.
struct MachineError : std::runtime_error {
    MachineError(int exit_code, const std::string& text)
        : std::runtime_error(text), code(exit_code) {}
    int code;  ///< The first failing child's exit code, 128 + signal, or 69 (unavailable).
    bool is_interruption = false;  ///< Caused by a signal to the host: not an error.
};

/// The user canceled the operation under way, by Ctrl-C or in another way. The machine continues.
struct Cancelled : RequestError {
    Cancelled() : RequestError(ExitCode::failed, "canceled") {}
};

/// The traces that the nodes and the host have written.
struct SavedTraces {
    std::string folder;
    int nodes = 0;
    std::uint64_t messages = 0, bytes = 0;
    std::vector<std::string> missing;  ///< "gp-3: <reason>" for each node that failed.
};

/// A node of the ring.
struct MachineNode {
    bus::NodeId id = 0;
    bus::schema::Role role = bus::schema::Role::host;
    std::string name;  ///< "gp-3".
};

/// A running machine. One thread uses it.
class MachinePort {
  public:
    virtual ~MachinePort() = default;

    virtual const std::vector<bus::NodeId>& gp_ids()
        const = 0;  ///< In order of index; [0] is the Master GP.
    virtual const std::vector<bus::NodeId>& renderer_ids() const = 0;

    /// All nodes in ring order, the host first, without the io process.
    virtual std::vector<MachineNode> nodes() const { return {}; }
    /// Messages and bytes that the host has sent and received.
    virtual bus::Traffic traffic() const { return {}; }
    /// Kills the process of a node other than the host, and waits for its end. The machine ends as
    /// after any death: pump() and the other functions throw MachineError.
    virtual void kill(bus::NodeId) {
        throw RequestError(ExitCode::usage, "this machine has no processes to kill");
    }

    virtual void send(bus::NodeId to, bus::Payload payload) = 0;
    /// Memory for builders of large bodies (bus::Link::body_allocator), or null for the heap.
    virtual flatbuffers::Allocator* body_allocator() { return nullptr; }
    /// Whether all messages sent to `to` have had credit.
    virtual bool takes_more(bus::NodeId to) const = 0;

    /// Passes every message to `take`, in order of arrival, until `done` returns true. Calls `done`
    /// first, then after each message and whenever credit may have come. Throws MachineError when a
    /// node dies or the machine is interrupted.
    virtual void pump(const std::function<void(const bus::Message&)>& take,
                      const std::function<bool()>& done) = 0;

    /// Waits until reading `fd` would not block. Files on disk never block. Keeps messages that
    /// come meanwhile for the next pump(). Throws MachineError as pump() does.
    virtual void wait_readable(int fd) = 0;

    /// Starts the process of the next start_io() ahead. The process loads hundreds of libraries
    /// while the session works. Throws RequestError (unavailable) if it cannot be started.
    virtual void prepare_io() = 0;

    /// Starts a pxpl5-io process and returns its id. If it dies before release_io(), pump() throws
    /// RequestError, and the machine continues.
    ///
    /// on_death  The error's code: bad_data if the process decodes a file, failed if it writes one.
    virtual bus::NodeId start_io(ExitCode on_death = ExitCode::bad_data) = 0;
    /// Ends the io process.
    virtual void release_io() = 0;

    /// While `allowed`, the first SIGINT cancels the operation under way: the io process is killed,
    /// and pump() and start_io() throw the cancellation. A further or an earlier SIGINT ends the
    /// machine. Throws as pump() does.
    virtual void allow_cancel(bool allowed) = 0;

    /// Calls `give_up` during pump() whenever `fd` is readable (-1: stops calling it). `give_up`
    /// must leave `fd` unreadable. If it returns true while canceling is allowed, it acts as the
    /// first SIGINT.
    virtual void watch(int fd, std::function<bool()> give_up) = 0;

    virtual bool is_recording() const = 0;
    /// Orders every node to write its recording. Recording continues.
    /// Throws RequestError (usage) if nothing is recorded, MachineError as pump() does.
    virtual SavedTraces save_traces() = 0;
};

}  // namespace pxpl5::host
