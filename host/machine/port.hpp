// The machine as a session sees it: nodes to send to, and messages that come back.
#pragma once

#include <cstdint>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/base/error.hpp"
#include "host/machine/topology.hpp"
#include "ringbus/message.hpp"
#include "ringbus/traffic.hpp"

namespace pxpl5::host {

/// The machine has ended: a process died or could not start. `what` names the first cause.
struct MachineError : std::runtime_error {
    MachineError(int exit_code, const std::string& text)
        : std::runtime_error(text), code(exit_code) {}
    MachineError(ExitCode exit_code, const std::string& text)
        : MachineError(static_cast<int>(exit_code), text) {}
    int code;  ///< The first failing child's exit code, 128 + signal, or 69 (unavailable).
    bool is_interruption = false;  ///< Caused by a signal to the host: not an error.
    bool is_final = false;         ///< The machine may not be started again.
    std::string node;              ///< The node that died or hung: "gp-3"; empty if unknown.
};

/// The user canceled the operation under way, by Ctrl-C or in another way. The machine continues.
struct Canceled : RequestError {
    Canceled() : RequestError(ExitCode::failed, "canceled") {}
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
    std::string name;           ///< "gp-3".
    std::string computer = {};  ///< Its name. Empty in a machine on one computer.
    int place = 0;              ///< Equal for nodes that share memory.
};

/// The part of a computer in a machine.
enum class ComputerUse : std::uint8_t {
    used,     ///< It has nodes.
    idle,     ///< It has joined and has no nodes.
    lost,     ///< It does not answer, or has left.
    released  ///< The user has ended its part.
};

/// A computer beside the host's own.
struct MachineComputer {
    std::string name;
    ComputerUse use = ComputerUse::idle;
    int cores = 0;
    int nodes = 0;
    std::string why = {};  ///< Why it is lost.
};

/// Nodes that a machine gets, or loses, when it is started again.
struct NodeChange {
    int gps = 0, renderers = 0;
};

/// A running machine. One thread uses it.
class MachinePort {
  public:
    virtual ~MachinePort() = default;

    virtual const std::vector<bus::NodeId>& gp_ids()
        const = 0;  ///< In order of index; [0] is the Master GP.
    virtual const std::vector<bus::NodeId>& renderer_ids() const = 0;
    virtual const std::vector<bus::NodeId>& frame_buffer_ids() const = 0;  ///< In order of index.

    /// All nodes in ring order, the host first, without the io process.
    virtual std::vector<MachineNode> nodes() const { return {}; }
    /// Messages and bytes that the host has sent and received.
    virtual bus::Traffic traffic() const { return {}; }
    /// Kills the process of a node other than the host, and waits for its end. The machine ends as
    /// after any death: pump() and the other functions throw MachineError.
    virtual void kill(bus::NodeId) {
        throw RequestError(ExitCode::usage, "this machine has no processes to kill");
    }

    /// The settings for the death of a node, for example "gp-3"; for an unknown one the GPs'.
    virtual RestartSettings restart_of(const std::string&) const {
        return {RestartPolicy::end, 0, 0};
    }
    /// Ends what is left of the machine, and starts it again. Ids of GPs and Renderers may change;
    /// the nodes have no content. watch() and name_surfaces() stay in force.
    ///
    /// pause_ms  Time to wait before, while signals to the host are heard.
    /// Throws MachineError if the machine cannot be started. Then it may be tried again. Throws
    /// RequestError (usage) for a count out of range; the machine continues.
    virtual void start_again(const NodeChange&, int pause_ms = 0) {
        static_cast<void>(pause_ms);
        throw RequestError(ExitCode::usage, "this machine cannot be started again");
    }

    /// The computers that have joined, and those that were lost or released since.
    virtual std::vector<MachineComputer> computers() const { return {}; }
    /// Lets the next start_again() put nodes on every computer that has joined.
    ///
    /// name  Waits until this computer has joined, and starts it if necessary; empty: none.
    /// Throws RequestError (unavailable) if it does not join; the machine continues.
    virtual void use_computers(const std::string& name) {
        static_cast<void>(name);
        throw RequestError(ExitCode::usage, "this machine has no other computers");
    }
    /// Lets the computer end at the next start_again(), or at once if it has no nodes.
    /// Returns true if it has nodes. Throws RequestError (usage) if it takes no part, or if it is
    /// the last one.
    virtual bool release_computer(const std::string& name) {
        throw RequestError(ExitCode::usage, "no computer of this machine is called '" + name + "'");
    }
    /// The line that a user types on another computer to let it join. The line names a file with
    /// the key.
    virtual std::string join_line() {
        throw RequestError(ExitCode::usage, "this machine has no other computers");
    }
    /// Calls `tell` when a computer has joined the running machine, or has left without having
    /// nodes: "n4 with 16 cores has joined". Empty: standard error alone gets the text.
    virtual void tell_computers(std::function<void(const std::string&)> tell) {
        static_cast<void>(tell);
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
    /// must leave `fd` unreadable. After it has returned true, it acts as the first SIGINT, once
    /// allow_cancel() or allow_give_up() has allowed that.
    virtual void watch(int fd, std::function<bool()> give_up) = 0;
    /// While `allowed`, the function of watch() may cancel the operation under way. SIGINT may not,
    /// but see cancel_on_interrupt().
    virtual void allow_give_up(bool) {}
    /// While `allowed`, as during a command of a prompt, a SIGINT cancels the current or the next
    /// work that allow_give_up() or allow_cancel() allows to cancel. A second SIGINT before that
    /// ends the machine. An unused SIGINT is dropped when this ends.
    virtual void cancel_on_interrupt(bool) {}

    /// Names the work that the following pump() waits for, for errors: "surface bone".
    virtual void name_work(const std::string&) {}
    /// Calls `name_of` for the name of a surface's id, for errors. Empty: names are unknown.
    virtual void name_surfaces(std::function<std::string(std::uint32_t)>) {}

    /// Calls `tell` once for a node that does not answer, before the node is ended for that:
    /// "gp-0 (process 71) has not answered for 2.0 s while ...". Empty: standard error alone
    /// gets the text.
    virtual void tell_suspects(std::function<void(const std::string&)> tell) {
        static_cast<void>(tell);
    }

    /// Adjacent slabs that the topology gives to one GP; 0: the volume's size decides.
    virtual int slabs_per_set() const { return 0; }

    virtual bool is_recording() const = 0;
    /// Orders every node to write its recording. Recording continues.
    /// Throws RequestError (usage) if nothing is recorded, MachineError as pump() does.
    virtual SavedTraces save_traces() = 0;
    /// The same after a fault, with a short limit, because the user waits for the error.
    virtual SavedTraces save_traces_after_fault() { return save_traces(); }

    /// Folders outside of a header's own in which its data files may lie.
    virtual std::vector<std::string> io_folders() const { return {}; }
};

}  // namespace pxpl5::host
