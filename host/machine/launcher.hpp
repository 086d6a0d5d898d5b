// Brings the processes of a machine up, watches them, and brings them down.
#pragma once

#include <csignal>
#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "host/machine/handshake.hpp"
#include "host/machine/machine.hpp"
#include "host/machine/port.hpp"
#include "host/machine/roster.hpp"
#include "host/machine/run_folder.hpp"
#include "host/machine/supervisor.hpp"
#include "ringbus/trace/recorder.hpp"
#include "ringbus/zmq/zmq_link.hpp"

namespace pxpl5::host {

/// What flight recorders hold in all, beside the last two frames. More of it would be shared memory
/// that nodes fill anew for every frame instead of finding it in their caches.
inline constexpr std::size_t flight_kib = std::size_t{64} << 10;

/// What may wait for the session while it does not pump; more is a node gone wild.
inline constexpr std::size_t max_backlog_messages = std::size_t{1} << 14;
inline constexpr std::size_t max_backlog_bytes = 2 * bus::max_body_bytes;

/// Keeps signals away from this thread: who is born or dies under it cannot be cut short.
class HeldSignals {
  public:
    HeldSignals();
    ~HeldSignals();
    HeldSignals(const HeldSignals&) = delete;
    HeldSignals& operator=(const HeldSignals&) = delete;
    void hold();
    void release();

  private:
    sigset_t before_{};
};

/// What Machine is made of. Every failure ends the machine first and is thrown then.
class Launcher {
  public:
    /// Prepares folders and the host's own address; starts nothing.
    Launcher(const Topology& topology, const MachineOptions& options);

    ~Launcher();
    Launcher(const Launcher&) = delete;
    Launcher& operator=(const Launcher&) = delete;

    /// Starts all nodes and takes them through the barriers. Throws MachineError.
    void launch();

    /// As MachinePort::prepare_io().
    void prepare_io();
    /// Starts one more process, which knows the host alone. Throws RequestError if it ends early,
    /// with the code `on_death`, as check_health() does later; MachineError as check_health().
    bus::NodeId start_io(ExitCode on_death);
    /// Tells it to end; it goes on its own, and is killed if it is still there at the next one.
    void release_io();

    /// The next message, if one is here; never one of the handshake. Throws MachineError.
    std::optional<bus::Message> receive();
    void send(bus::NodeId to, bus::Payload payload);
    flatbuffers::Allocator* body_allocator() { return link_.body_allocator(); }
    bool takes_more(bus::NodeId to) const { return link_.takes_more(to); }
    bus::Traffic traffic() const { return link_.traffic(); }
    /// As MachinePort::kill().
    void kill(bus::NodeId id);
    /// Waits for a message or for something that check_health() tells of.
    void wait();

    /// As MachinePort::wait_readable().
    void wait_readable(int fd);

    /// Throws MachineError if a node has died or a signal came, RequestError if the io process has
    /// died, Cancelled as allow_cancel() says.
    void check_health();

    /// As MachinePort::allow_cancel().
    void allow_cancel(bool allowed);
    bool can_be_cancelled() const { return can_be_cancelled_; }
    /// As MachinePort::watch().
    void watch(int fd, std::function<bool()> give_up);

    bool is_recording() const { return recorder_.has_value(); }
    /// As MachinePort::save_traces().
    SavedTraces save_traces();

    /// Orderly end. Throws MachineError if a node has died, does not end by itself, or not with 0,
    /// or if a signal came.
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
    /// Adds to the backlog. Throws MachineError if it is full.
    void keep(const bus::Message& message);
    /// The next message that is here and for now.
    std::optional<bus::Message> take_from_link();
    bool is_not_for_now(const bus::Message& message);
    RosterEntry spawn_io();
    void drop_prepared_io();
    /// Forgets io processes that have ended; kills those that have not.
    void bury_dismissed();
    void dismiss_io();
    /// Whether an io process of the past died, which may do so as it likes.
    bool was_dismissed(const Death& death) const;
    /// Asks whoever watches, if there is something to ask. Throws Cancelled.
    void ask_watcher();
    /// Ends the io process at once and throws Cancelled.
    [[noreturn]] void cancel();
    std::string describe(const Death& death) const;
    [[noreturn]] void fail(int code, const std::string& text);
    /// Ends the machine because of a signal to the host, which is nobody's fault.
    [[noreturn]] void give_in(const MachineError& cause);
    /// Ends everyone. Returns the first cause if that was not orderly: a death, or a signal to us.
    std::optional<MachineError> bring_down(int grace_ms);
    void discard_messages();

    // Recording, in launcher_traces.cpp.
    void start_recording();
    /// Each node's share of flight_kib.
    int flight_share_kib() const;
    void note(const bus::Message& message);
    /// Runs what may fail to write; a failure is thrown by the next check_health().
    void guard_recording(const std::function<void()>& act);
    std::filesystem::path trace_path(const std::string& file) const;
    void flush_trace();
    /// Tells the nodes that run, and the host, to write. Returns those to wait for.
    std::set<bus::NodeId> ask_for_traces(SavedTraces& saved);
    void take_answer(const bus::Message& message, SavedTraces& saved) const;
    /// Where to look for the cause, for the end of an error's text; empty if nothing is recorded.
    std::string traces_of_failure();
    std::optional<MachineError> close_trace();

    Topology topology_;
    MachineOptions options_;
    std::filesystem::path folder_;
    HeldSignals signals_;  // Around the sockets, which are removed even if one comes at the end.
    SocketFolder sockets_;
    std::optional<bus::trace::Recorder> recorder_;
    std::optional<std::string> record_failure_;  ///< Not told yet.
    bus::ZmqLink link_;
    Supervisor supervisor_;  // Behind the link: children end before the socket that they know.
    Roster roster_;          ///< Host first.
    std::optional<RosterEntry> io_;
    std::optional<RosterEntry> prepared_io_;   ///< Started, and not yet taken into the machine.
    std::optional<bus::Message> early_hello_;  ///< Of the prepared one.
    int io_count_ = 0;
    ExitCode io_death_code_ = ExitCode::bad_data;
    bool can_be_cancelled_ = false;
    int watched_fd_ = -1;
    std::function<bool()> give_up_;                 ///< Of watch().
    bool launched_ = false;                         ///< All nodes have been told Go.
    std::map<bus::NodeId, std::string> dismissed_;  ///< io processes of the past, by name.
    /// Came while a handshake was going on, or while the host waited for its input.
    std::deque<bus::Message> backlog_;
    std::size_t backlog_bytes_ = 0;
    std::optional<MachineError> over_;  ///< Why nothing works any more.
};

}  // namespace pxpl5::host
