// Starts the processes of a machine, watches them and ends them.
#pragma once

#include <csignal>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "host/base/kernel/memory_kills.hpp"
#include "host/base/kernel/socket_folder.hpp"
#include "host/machine/computers/processes.hpp"
#include "host/machine/handshake.hpp"
#include "host/machine/heartbeat.hpp"
#include "host/machine/machine.hpp"
#include "host/machine/port.hpp"
#include "host/machine/processes/supervisor.hpp"
#include "host/machine/roster.hpp"
#include "host/machine/run_folder.hpp"
#include "ringbus/process/process.hpp"
#include "ringbus/trace/recorder.hpp"
#include "ringbus/zmq/credentials.hpp"
#include "ringbus/zmq/zmq_link.hpp"

namespace pxpl5::host {

/// Exit code if a node does not answer in time.
inline constexpr int timeout_code = 124;

/// Limit for nodes to write their traces on request.
inline constexpr int save_ms = 60'000;
/// The same after a fault, while the user waits for the error.
inline constexpr int fault_save_ms = 3'000;

/// Memory of all flight recorders together, beside the last two frames. With more, nodes would
/// write into shared memory that is in no cache.
inline constexpr std::size_t flight_kib = std::size_t{64} << 10;

/// Limits of the messages that wait while the session does not pump. More than that is a fault of
/// the node.
inline constexpr std::size_t max_backlog_messages = std::size_t{1} << 14;
inline constexpr std::size_t max_backlog_bytes = 2 * bus::max_body_bytes;

/// Whether memory ran out while a process lived.
enum class MemoryLack {
    none,
    found,    ///< The kernel has killed a process of this program's control group.
    perhaps,  ///< The kernel has killed a process of this computer.
    unknown
};

/// Compares the counts of before and after a death.
MemoryLack memory_lack(const std::optional<MemoryKills>& before,
                       const std::optional<MemoryKills>& after);

/// All that is known about the death of an io process.
struct IoDeath {
    Death death;
    std::string file;   ///< File or folder of the request.
    std::string doing;  ///< "while reading a volume"; may be empty.
    std::string said;   ///< The last line of the log; may be empty.
    std::filesystem::path log;
    MemoryLack memory = MemoryLack::unknown;
    bool has_request = true;                  ///< The process had taken its request.
    int cpu_s = 0;                            ///< The limit of processor time.
    ExitCode otherwise = ExitCode::bad_data;  ///< The code if the death has no other cause.
};

/// The error names file, process, signal and work, and a cause only if the cause is known.
IoFailure error_of(const IoDeath& io);

/// The address at which a process of this computer listens; `name` is its socket's.
std::string bind_address(Transport transport, const SocketFolder& sockets, const std::string& name);
/// The address of the host's ring socket.
std::string host_address(const Topology& topology, const SocketFolder& sockets);

/// Blocks signals for this thread, so that no signal interrupts construction or destruction.
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

/// The processes that end with a machine.
enum class Ending : std::uint8_t {
    nodes,  ///< The other computers wait for the next machine.
    all
};

/// The implementation of Machine. Every failure ends the machine before it is thrown.
class Launcher {
  public:
    /// Prepares folders and the host's own address. Starts no process.
    ///
    /// kept  The computers of the machine before, from keep_computers(); null: none.
    Launcher(const Topology& topology, const MachineOptions& options,
             std::shared_ptr<Processes> kept = {});

    ~Launcher();
    Launcher(const Launcher&) = delete;
    Launcher& operator=(const Launcher&) = delete;

    /// Starts all nodes and takes them through the barriers. Throws MachineError.
    void launch();

    /// See MachinePort::prepare_io().
    void prepare_io();
    /// Starts an io process, which knows only the host. Throws RequestError with the code
    /// `on_death` if the process ends early; check_health() does so later. Throws MachineError as
    /// check_health() does.
    bus::NodeId start_io(ExitCode on_death);
    /// Orders the io process to end, without waiting. The next start kills it if it still runs.
    void release_io();

    /// The next message, if one has arrived. Never a message of the handshake. Throws MachineError.
    std::optional<bus::Message> receive();
    void send(bus::NodeId to, bus::Payload payload);
    flatbuffers::Allocator* body_allocator() { return link_.body_allocator(); }
    bool takes_more(bus::NodeId to) const { return link_.takes_more(to); }
    bus::Traffic traffic() const { return link_.traffic(); }
    /// See MachinePort::kill().
    void kill(bus::NodeId id);
    /// Begins to wait for the answer to `work`.
    void begin_wait() { heartbeat_.note_answer(); }
    /// Waits for a message or for an event that check_health() reports.
    void wait();
    /// See MachinePort::name_work(), MachinePort::name_surfaces().
    void name_work(const std::string& work) { work_ = work; }
    void name_surfaces(NameOfSurface name_of) { heartbeat_.name_surfaces(std::move(name_of)); }

    /// See MachinePort::wait_readable().
    void wait_readable(int fd);
    /// Waits `ms` milliseconds, also after the machine has ended. Throws MachineError if a signal
    /// to the host comes.
    void rest(int ms);

    /// Throws MachineError if a node has died or does not answer, or a signal came, RequestError if
    /// this is the io process. Throws the cancellation of allow_cancel().
    void check_health();

    /// See MachinePort::allow_cancel().
    void allow_cancel(bool allowed);
    bool can_be_canceled() const { return interrupt_.cancels; }
    /// See MachinePort::watch().
    void watch(int fd, std::function<bool()> give_up);
    /// See MachinePort::tell_suspects().
    void tell_suspects(std::function<void(const std::string&)> tell) {
        watcher_.tell_suspect = std::move(tell);
    }
    /// See MachinePort::allow_give_up().
    void allow_give_up(bool allowed) { watcher_.may_cancel = allowed; }
    /// See MachinePort::cancel_on_interrupt().
    void cancel_on_interrupt(bool allowed);

    bool is_recording() const { return recorder_.has_value(); }
    /// See MachinePort::save_traces().
    SavedTraces save_traces(int limit_ms);

    /// Ends the machine in order. Throws MachineError if a signal came, or if a node has died, does
    /// not end by itself or ends with an exit code other than 0.
    void shutdown() { shutdown(Ending::all); }
    /// The same, but leaves the other computers without nodes.
    void shutdown_nodes() { shutdown(Ending::nodes); }
    /// The computers for the next machine, after the end of the nodes; null if there are none.
    std::shared_ptr<Processes> keep_computers();

    const Roster& roster() const { return roster_; }
    /// See MachinePort::nodes().
    std::vector<MachineNode> nodes() const;
    /// See MachinePort.
    std::vector<MachineComputer> computers() const;
    void await_computer(const std::string& name);
    bool release_computer(const std::string& name);
    std::string join_line();
    void tell_computers(std::function<void(const std::string&)> tell) {
        watcher_.tell_computer = std::move(tell);
    }
    const std::filesystem::path& folder() const { return folder_; }
    std::string name_of(bus::NodeId id) const;

  private:
    /// A descriptor of a new pulse for the process `name`; -1 if the heartbeat is off.
    int prepare_pulse(const std::string& name);
    void spawn(RosterEntry& node, const RoleSettings& settings, std::vector<std::string> arguments);
    /// Where the node listens, and where it finds the host.
    bus::ProcessFlags flags_of(const RosterEntry& node) const;

    // Other computers, in computers/launcher_computers.cpp.
    /// Starts the engine, waits until all computers have joined, and places the nodes.
    void gather_computers();
    void await_computers();
    /// True if the computers that are here are not enough.
    bool needs_engine() const;
    /// Starts the engine and waits for the computers that a plan needs.
    void call_computers();
    /// The named computers that have not joined, for an error.
    std::string missing_computers() const;
    /// Compresses messages between computers if the network is slow.
    void measure_network();
    /// Throws MachineError if the computer is lost.
    void require_computer(const RemoteComputer& computer) const;
    /// 10^6 bytes per second from a computer to this one; nothing if it does not answer.
    std::optional<double> measured_mb_s(int number);
    void place();
    /// The addresses and paths of a node of a machine with other computers.
    void add_computer_flags(const RosterEntry& node, bus::ProcessFlags& flags) const;
    /// Asks for the trace of a node on another computer.
    void fetch_trace(bus::NodeId id);
    /// Waits until the traces of other computers have come.
    void await_fetched(SavedTraces& saved, std::int64_t deadline_ms);
    void print_news_of_computers();
    /// Leaves computers out of the plan that were lost or released, and says so.
    void leave_out_former();

    /// Waits for messages, deaths, signals and letters, at most `most_ms` (-1: no limit).
    void wait_for_event(int most_ms);
    /// Sends `signal` to a process and waits for its end, at most `most_ms`.
    void end_process(const std::string& name, int signal, int most_ms);
    /// Takes the started `nodes` through the barriers: Hello, topology, Connected, Go.
    Roster bring_up(Roster nodes);
    using Missing = std::function<std::vector<std::string>()>;
    /// The time to wait: until the next look at the heartbeat, at most `most_ms` (-1: no limit).
    int wait_ms(std::int64_t most_ms) const;
    void await(const std::string& what, Handshake& handshake, const Missing& missing);
    void take_control(const bus::Message& message, Handshake& handshake);
    /// Sets up the link: its model, and its reports of dropped messages.
    void prepare_link();
    void take_refusal(const bus::Refusal& refusal);
    void report_refusals() const;
    /// Ends what node `id` belongs to, because the node cannot be trusted: a request if the node is
    /// an io process, else the machine. Returns if no request depends on the io process.
    void blame(bus::NodeId id, int code, const std::string& text);
    /// Adds to the backlog. Throws MachineError if the backlog is full.
    void keep(const bus::Message& message);
    /// The next message that has arrived and needs no waiting.
    std::optional<bus::Message> take_from_link();
    bool is_not_for_now(const bus::Message& message);
    RosterEntry spawn_io();
    /// Whether a used, prepared or dismissed io process has this id, or this index.
    bool has_io_id(bus::NodeId id) const;
    bool has_io_index(int index) const;
    /// The error of an io process that has died.
    IoFailure io_error(const Death& death);
    void drop_prepared_io();
    /// Forgets io processes that have ended. Kills those that still run.
    void bury_dismissed();
    void dismiss_io();
    /// Whether the dead process was a dismissed io process, which may end in any way.
    bool was_dismissed(const Death& death) const;
    /// Calls the function of watch() if its descriptor is readable. Throws the cancellation.
    void ask_watcher();
    void kill_io();
    /// Kills the io process and throws the cancellation.
    [[noreturn]] void cancel();
    /// Looks at the heartbeat. Ends nodes that do not answer, and throws as check_health() does.
    void check_heartbeat();
    /// Ends the machine if no node works on the answer that the host waits for.
    void check_answer();
    std::string describe(const Death& death) const;
    /// Ends the machine. `node` is the name of the node at fault, if it is known.
    [[noreturn]] void fail(int code, const std::string& text, const std::string& node = {});
    /// Ends the machine because of a signal to the host, which is not an error.
    [[noreturn]] void give_in(const MachineError& cause);
    void shutdown(Ending ending);
    /// Ends all nodes, or all processes and other computers. Returns the first cause if the end was
    /// not orderly: a death, or a signal to the host.
    std::optional<MachineError> bring_down(int grace_ms, Ending ending);
    std::optional<MachineError> end_processes(int grace_ms, Ending ending);
    /// Ends the other computers, if keep_computers() was not called.
    void end_computers();
    /// Drops at most max_discarded messages, so that no flood delays the end.
    void discard_messages(bool are_recorded);

    // Recording, in launcher_traces.cpp.
    void start_recording();
    /// Each node's share of flight_kib.
    int flight_share_kib() const;
    void note(const bus::Message& message);
    /// Runs `act`, which writes. The next check_health() throws its failure.
    void guard_recording(const std::function<void()>& act);
    std::filesystem::path trace_path(const std::string& file) const;
    void flush_trace();
    /// Orders the running nodes and the host to write. Returns the nodes to wait for.
    std::set<bus::NodeId> ask_for_traces(SavedTraces& saved);
    void take_answer(const bus::Message& message, SavedTraces& saved);
    /// Traces that the host waits for.
    struct AwaitedTraces {
        std::set<bus::NodeId> nodes, asked_again;
    };
    /// Takes the answer to a SaveTrace. Asks a node that refused the message once more, because a
    /// node refuses the message after a lost one. Returns false for other messages.
    bool take_trace_answer(const bus::Message& message, AwaitedTraces& awaited, SavedTraces& saved);
    /// The end of an error's text: where the traces are. Empty if nothing is recorded.
    std::string traces_of_failure();
    std::optional<MachineError> close_trace();

    /// The io process and its successor. A new io process is started after each death.
    struct IoProcesses {
        std::string host_endpoint;  ///< The host's socket for io processes.
        std::optional<RosterEntry> used;
        std::optional<RosterEntry> prepared;      ///< Started, but not in use yet.
        std::optional<bus::Message> early_hello;  ///< The prepared process's first message.
        unsigned started = 0;
        ExitCode death_code = ExitCode::bad_data;
        std::optional<MemoryKills> memory_kills;       ///< At the start of `used`.
        std::map<bus::NodeId, RosterEntry> dismissed;  ///< Earlier io processes.
        std::optional<bus::Refusal> offense;           ///< A forbidden message of an io process.
    };

    Topology topology_;
    MachineOptions options_;
    bus::Credentials credentials_;
    std::filesystem::path folder_;
    HeldSignals signals_;  // Outlives the sockets: a late signal must not keep their removal.
    SocketFolder sockets_;
    std::optional<bus::trace::Recorder> recorder_;
    std::optional<std::string> record_failure_;  ///< Not reported yet.
    bus::ZmqLink link_;
    std::shared_ptr<Processes> owned_;  // After the link: children end before their host's socket.
    Processes& processes_;              ///< `owned_`, also after keep_computers().
    Roster roster_;                     ///< Host first.
    Heartbeat heartbeat_;
    std::string work_ = "request";  ///< The work that the session waits for.
    IoProcesses io_;
    /// See MachinePort::watch().
    struct Watcher {
        int fd = -1;
        std::function<bool()> give_up;
        bool may_cancel = false;  ///< See MachinePort::allow_give_up().
        bool has_given_up = false;
        std::function<void(const std::string&)> tell_suspect;   ///< See tell_suspects().
        std::function<void(const std::string&)> tell_computer;  ///< See tell_computers().
    };

    /// The meaning of a SIGINT.
    struct Interrupt {
        bool cancels = false;          ///< See MachinePort::allow_cancel().
        bool cancels_command = false;  ///< See MachinePort::cancel_on_interrupt().
        bool is_pending = false;       ///< One has come, and has canceled nothing so far.
    };

    Watcher watcher_;
    Interrupt interrupt_;
    bool launched_ = false;  ///< All nodes have received Go.
    /// Messages that came during a handshake, or while the host waited for input.
    struct Backlog {
        std::deque<bus::Message> messages;
        std::size_t bytes = 0;
    };
    Backlog backlog_;
    std::optional<MachineError> over_;  ///< Why the machine has ended.
};

}  // namespace pxpl5::host
