// The computers that have joined a machine, as the host sees them.
#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "host/machine/computers/join/letter.hpp"
#include "host/machine/handshake.hpp"
#include "host/machine/processes/supervisor.hpp"
#include "host/machine/topology.hpp"
#include "ringbus/pulse.hpp"
#include "ringbus/zmq/line.hpp"

namespace pxpl5::host {

/// A computer that has joined.
struct RemoteComputer {
    std::string line;  ///< For bus::LinePort::send().
    join::FactsT facts;
    std::int64_t silent_ms = 0;  ///< While the host listened.
    bool is_lost = false;
    bool is_released = false;       ///< The user wants it to end.
    std::string leaves;             ///< Why it is lost, or ends; empty while it takes part.
    std::string engine;             ///< The process that has started it and others: "engine-slurm".
    bool ends_with_engine = false;  ///< It leaves because `engine` has ended.
    std::set<std::string> running;  ///< Names of its processes.
    int measured = 0;               ///< Answers to ask_bytes() that have come.

    bool takes_part() const { return !is_lost && !is_released && leaves.empty(); }
};

/// A computer that took part before.
struct FormerComputer {
    std::string name;
    int cores = 0;
    bool is_released = false;
    std::string why;  ///< Why it was lost.
};

/// Lets computers join, starts processes on them and notices when a computer is lost. Outlives the
/// machines of a session. The first computer that joins has number 1, and a computer keeps its
/// number while a machine runs. Number 0 is the host's own computer.
class RemoteComputers {
  public:
    /// cluster  Where the port for computers is.
    /// folder  The run folder, which takes the logs and traces of the processes.
    /// Throws std::runtime_error if the address cannot be used.
    RemoteComputers(const ClusterSettings& cluster, const bus::Credentials& credentials,
                    Identity identity, std::filesystem::path folder);

    /// "tcp://10.0.0.1:4711,tcp://192.168.1.1:4711": where computers can join.
    std::string addresses() const;
    int poll_fd() const { return port_.poll_fd(); }
    /// Takes the letters that have come. Counts the silence of each computer.
    void pump(std::int64_t now_ms);

    const std::deque<RemoteComputer>& computers() const { return computers_; }
    /// True if a computer of this name takes part.
    bool takes_part(const std::string& name) const;
    /// The computers that are not here any more, but have not joined again.
    const std::vector<FormerComputer>& former() const { return gone_.computers; }

    /// Begins another machine: dismisses the computers that were lost or released, and frees the
    /// numbers of all. Returns the names of those that were lost since the last call.
    ///
    /// folder  The new run folder.
    std::vector<std::string> open(std::filesystem::path folder);
    /// Numbers the computers in the order of `names`, then by name, so that nodes do not depend on
    /// who came first. Computers that join from now on have no nodes in this machine.
    void close(const std::vector<std::string>& names);
    bool is_open() const { return is_open_; }
    /// True if open() has dismissed computers because their engine has ended.
    bool needs_engine() const { return needs_engine_; }
    /// The processes that have started several computers, of which one is lost. Slurm or Open MPI
    /// may end the others, too.
    std::set<std::string> broken_engines() const;
    /// The process that starts the computers that join before close().
    void expect_from(const std::string& engine) { engine_ = engine; }
    /// Notes that a process of an engine has ended: its computers leave. Returns true if processes
    /// of the machine run on them.
    bool take_end_of_engine(const std::string& engine, const std::string& why);
    /// The computer shall end before the next machine; at once if it has no process. Returns false
    /// if it takes no part.
    bool release(const std::string& name);

    /// Asks computer `number` for `bytes` bytes, at most a MiB. They have come when it has measured
    /// one time more (RemoteComputer).
    void ask_bytes(int number, std::uint32_t bytes);

    /// Starts a process on computer `number`. take_deaths() reports a failure.
    /// pulse_ms  0: the process has no pulse.
    void spawn(int number, const ProcessCommand& command, int pulse_ms);
    void kill(const std::string& name, int signal);
    void kill_all(int signal);
    bool has(const std::string& name) const;
    std::vector<std::string> running() const;
    std::vector<Death> take_deaths();
    /// Asks for a file of a running process's computer.
    void fetch(const std::string& name, const std::string& file);
    const std::set<std::string>& awaited_files() const { return awaited_files_; }
    /// True if a part of a file has come since the last call, and the file is not complete.
    bool takes_parts();

    /// Called with each pulse that comes.
    void on_pulse(std::function<void(const std::string& name, const bus::PulseNumbers&)> take) {
        take_pulse_ = std::move(take);
    }
    /// Lines for the user: who was refused, and why. Each at most once.
    std::vector<std::string> take_warnings();
    /// Sentences for the user about computers without nodes: they have joined, or left.
    std::vector<std::string> take_news() { return std::exchange(news_, {}); }
    std::uint64_t refused() const { return port_.refused() + refused_; }
    /// Orders all computers to end.
    void finish();

    /// Time between two letters of a computer.
    static constexpr int beat_ms = 250;
    /// A computer that is silent for longer is lost.
    static constexpr int lost_ms = 750;

  private:
    RemoteComputer* computer_of_line(const std::string& line);
    RemoteComputer* computer_of(const std::string& process);
    RemoteComputer* present(const std::string& name);
    void dismiss(const RemoteComputer& computer);
    /// Keeps what is known of a computer that is not here any more.
    void bury(const RemoteComputer& computer);
    void take(const std::string& line, const join::LetterT& letter);
    void take_ask(const std::string& line, const join::AskT& ask);
    std::string reason_to_refuse(const join::AskT& ask) const;
    void take_beat(const RemoteComputer& computer, const join::BeatT& beat);
    void take_content(const RemoteComputer& computer, const join::ContentT& content);
    void take_ended(RemoteComputer& computer, const join::EndedT& ended);
    void lose(RemoteComputer& computer, const std::string& silence);
    void forget_files_of(const std::string& name);
    void warn(const std::string& text);

    bus::LinePort port_;
    std::string listen_;
    bus::Credentials credentials_;
    Identity identity_;
    std::filesystem::path folder_;
    bool is_open_ = true, needs_engine_ = false;
    std::string engine_;
    std::deque<RemoteComputer> computers_;  ///< A deque: references stay good while others join.
    struct Gone {
        std::set<std::string> lines;  ///< Their last letters may come.
        std::vector<FormerComputer> computers;
    };
    Gone gone_;
    std::vector<std::string> news_;
    std::vector<Death> deaths_;
    std::set<std::string> awaited_files_;  ///< Asked for, not complete.
    std::set<std::string> begun_files_;    ///< Files of which a part has come.
    bool has_new_parts_ = false;           ///< Since takes_parts().
    std::function<void(const std::string&, const bus::PulseNumbers&)> take_pulse_;
    std::vector<std::string> warnings_;
    std::set<std::string> warned_;
    std::uint64_t refused_ = 0;
    std::optional<std::int64_t> looked_ms_;
};

}  // namespace pxpl5::host
