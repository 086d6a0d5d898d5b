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

/// The machine is over: a process died or could not start. `what` names the first cause.
struct MachineError : std::runtime_error {
    MachineError(int exit_code, const std::string& text)
        : std::runtime_error(text), code(exit_code) {}
    int code;  ///< The first failing child's exit code, 128 + signal, or 69 (unavailable).
    bool is_interruption = false;  ///< A signal to this process asked for it: nobody's fault.
};

/// The person pressed Ctrl-C, or asked in another way, and what was under way can be given up by
/// itself.
struct Cancelled : RequestError {
    Cancelled() : RequestError(ExitCode::failed, "cancelled") {}
};

/// What the nodes, the host among them, have written of what they received.
struct SavedTraces {
    std::string folder;
    int nodes = 0;
    std::uint64_t messages = 0, bytes = 0;
    std::vector<std::string> missing;  ///< "gp-3: <reason>" for each node that could not.
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

    /// In ring order, the host first; not the io process.
    virtual std::vector<MachineNode> nodes() const { return {}; }
    /// What the host itself has sent and received.
    virtual bus::Traffic traffic() const { return {}; }
    /// Kills the process of a node other than the host; returns when it is dead. The machine ends
    /// as of any death: pump() and the others throw MachineError.
    virtual void kill(bus::NodeId) {
        throw RequestError(ExitCode::usage, "this machine has no processes to kill");
    }

    virtual void send(bus::NodeId to, bus::Payload payload) = 0;
    /// Memory for builders of large bodies (bus::Link::body_allocator), or null for the heap.
    virtual flatbuffers::Allocator* body_allocator() { return nullptr; }
    /// Whether nothing that was sent to `to` waits here for its credit.
    virtual bool takes_more(bus::NodeId to) const = 0;

    /// Hands every message that arrives to `take`, in order, until `done` returns true (it is asked
    /// first, and again after each message and whenever credit may have come). Throws MachineError
    /// when a node dies or the machine is interrupted.
    virtual void pump(const std::function<void(const bus::Message&)>& take,
                      const std::function<bool()>& done) = 0;

    /// Waits until reading `fd` would not block; files on disk never do. Messages that come
    /// meanwhile are kept for the next pump(). Throws MachineError as pump() does.
    virtual void wait_readable(int fd) = 0;

    /// Lets the next start_io() find its process started: it loads hundreds of libraries, while
    /// something else goes on. Throws RequestError (unavailable) if it cannot be started.
    virtual void prepare_io() = 0;

    /// Starts a pxpl5-io process and returns its id. Its death before release_io() is a
    /// RequestError thrown by pump(), and leaves the machine running.
    ///
    /// on_death  The error's code: bad_data if the process is to decode what somebody else wrote,
    ///           failed if it is to write.
    virtual bus::NodeId start_io(ExitCode on_death = ExitCode::bad_data) = 0;
    /// Ends the io process.
    virtual void release_io() = 0;

    /// While `allowed`, the first SIGINT ends only what is under way: pump() and start_io() throw
    /// Cancelled, and an io process is killed. Any further one ends the machine, and so does one
    /// that came before. Throws as pump().
    virtual void allow_cancel(bool allowed) = 0;

    /// Has `give_up` asked during pump() whenever `fd` is readable (-1: no longer); it must leave
    /// `fd` unreadable. If it says yes while cancelling is allowed, that is as the first SIGINT.
    virtual void watch(int fd, std::function<bool()> give_up) = 0;

    virtual bool is_recording() const = 0;
    /// Has every node write what it has recorded; recording goes on.
    /// Throws RequestError (usage) if nothing is recorded, MachineError as pump() does.
    virtual SavedTraces save_traces() = 0;
};

}  // namespace pxpl5::host
