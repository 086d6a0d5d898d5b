// The computers that have joined a machine, as the host sees them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "host/machine/computers/letter.hpp"
#include "host/machine/handshake.hpp"
#include "host/machine/supervisor.hpp"
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
    std::string leaves;             ///< Why it is lost, or ends; empty while it takes part.
    std::set<std::string> running;  ///< Names of its processes.
    int measured = 0;               ///< Answers to ask_bytes() that have come.
};

/// Lets computers join, starts processes on them and notices when a computer is lost. The first
/// computer that joins has number 1. Number 0 is the host's own computer.
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

    const std::vector<RemoteComputer>& computers() const { return computers_; }
    /// Names of the computers that are lost or have left by themselves.
    std::vector<std::string> lost() const;
    /// So many computers may join.
    void expect(std::size_t computers) { expected_ = computers; }
    /// No further computer may join. Numbers them in the order of `names`, then by name, so that
    /// nodes do not depend on who came first.
    void close(const std::vector<std::string>& names);

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
    std::uint64_t refused() const { return port_.refused() + refused_; }
    /// Orders all computers to end.
    void finish();

    /// Time between two letters of a computer.
    static constexpr int beat_ms = 250;
    /// A computer that is silent for longer is lost.
    static constexpr int lost_ms = 750;

  private:
    RemoteComputer* computer_of_line(const std::string& line);
    RemoteComputer* computer_of(const std::string& name);
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
    bool is_open_ = true;
    std::size_t expected_ = 1;
    std::vector<RemoteComputer> computers_;
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
