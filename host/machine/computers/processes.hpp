// The processes of a machine, on this computer and on others.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "host/machine/computers/engine.hpp"
#include "host/machine/computers/poll_set.hpp"
#include "host/machine/computers/remote_computers.hpp"
#include "host/machine/supervisor.hpp"
#include "host/machine/topology.hpp"

namespace pxpl5::host {

/// Starts, watches and ends processes by name. A Supervisor runs those of this computer, and
/// RemoteComputers the others. If the topology has no engine, there are no others.
class Processes {
  public:
    Processes(const Topology& topology, const bus::Credentials& credentials, Identity identity,
              std::filesystem::path folder);
    ~Processes();
    Processes(const Processes&) = delete;
    Processes& operator=(const Processes&) = delete;

    bool has_others() const { return others_.has_value(); }
    /// Requires has_others().
    RemoteComputers& others() { return *others_; }
    const RemoteComputers& others() const { return *others_; }
    Supervisor& own() { return own_; }

    /// Remembers which computers are lost now.
    /// dead  The process whose end is the cause; may be the one that an engine has for a computer.
    void note_lost(const std::string& dead);
    /// Names of the computers that were lost at note_lost().
    const std::vector<std::string>& lost() const { return lost_; }

    /// Starts the engine's processes. Throws RequestError (usage), MachineError.
    void start_engine(const std::filesystem::path& program);
    /// The line that a user types on other computers; empty unless the engine is `wait`.
    const std::string& join_line() const { return join_line_; }
    /// True for a process of the engine: its end is the end of computers.
    static bool is_engine(const std::string& name) { return name.starts_with(engine_prefix); }
    /// True if only processes of the engine run.
    bool only_engine_runs() const;
    /// Orders the other computers to end.
    void finish();

    /// computer  0 is this one. Returns the process id; 0 if the process is elsewhere.
    int spawn(int computer, const ProcessCommand& command, int pulse_ms);
    std::vector<Death> take_deaths();
    std::vector<std::string> running() const;
    void kill(const std::string& name, int signal);
    void kill_all(int signal);

    /// Takes what other computers have sent.
    void pump(std::int64_t now_ms);
    /// `link_fd`, or a descriptor that is readable if this or the port of the computers is.
    int poll_fd(int link_fd);
    /// `timeout_ms`, or less because other computers must be looked at.
    int wait_ms(int timeout_ms) const;

  private:
    Topology topology_;
    bus::Credentials credentials_;
    std::filesystem::path folder_;
    std::optional<RemoteComputers> others_;
    Supervisor own_;
    std::optional<PollSet> polled_;
    std::vector<int> inputs_;  ///< Write ends; their end ends `pxpl5 join`.
    std::string join_line_;
    std::vector<std::string> lost_;
    bool is_finished_ = false;
};

}  // namespace pxpl5::host
