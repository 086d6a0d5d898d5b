// The processes of a machine, on this computer and on others.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "host/machine/computers/engine.hpp"
#include "host/machine/computers/poll_set.hpp"
#include "host/machine/computers/remote_computers.hpp"
#include "host/machine/processes/supervisor.hpp"
#include "host/machine/topology.hpp"

namespace pxpl5::host {

/// Starts, watches and ends processes by name. A Supervisor runs those of this computer, and
/// RemoteComputers the others. If the topology has no engine, there are no others. With others, the
/// next machine of a session takes the object over, so that the computers stay.
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
    const bus::Credentials& credentials() const { return credentials_; }

    /// Begins a machine. Requires has_others().
    void begin(const std::filesystem::path& folder);
    /// The computers that were lost with the machine before.
    const std::vector<std::string>& lost() const { return lost_; }
    /// The link of a machine ends.
    void forget_link();

    /// Starts the processes of the engine of `cluster`. Throws RequestError (usage), MachineError.
    void start_engine(const ClusterSettings& cluster, const std::filesystem::path& program);
    /// Starts the engine for one more computer, which may be named by no topology.
    void start_engine_for(const std::string& computer, const std::filesystem::path& program);
    /// The end of an engine's process that was no death for the machine.
    std::optional<Death> ended_engine(const std::string& computer) const;
    /// Ends the engine's process for one computer, if there is one.
    void end_engine_of(const std::string& computer);
    /// See RemoteComputers::release().
    bool release(const std::string& computer);
    /// The line that a user types on other computers. Makes the file of the key, if there is none.
    /// Throws RequestError if the file cannot be made.
    const std::string& join_line(const std::filesystem::path& program);
    /// True for a process of the engine: its end is the end of computers.
    static bool is_engine(const std::string& name) { return name.starts_with(engine_prefix); }
    /// The log of a process.
    std::filesystem::path log_of(const std::string& name) const;
    /// Orders the other computers to end.
    void finish();
    bool is_finished() const { return is_finished_; }

    /// computer  0 is this one. Returns the process id; 0 if the process is elsewhere.
    int spawn(int computer, const ProcessCommand& command, int pulse_ms);
    /// The ends of engines are among them if they end nodes, or while computers are awaited.
    std::vector<Death> take_deaths();
    std::vector<std::string> running() const;
    /// The same without processes of the engine.
    std::vector<std::string> running_nodes() const;
    void kill(const std::string& name, int signal);
    /// Processes of the engine get another signal than SIGKILL only after all nodes have ended.
    void kill_all(int signal, bool spares_engine);

    /// Takes what other computers have sent.
    void pump(std::int64_t now_ms);
    /// `link_fd`, or a descriptor that is readable if this or the port of the computers is.
    int poll_fd(int link_fd);
    /// `timeout_ms`, or less because other computers must be looked at.
    int wait_ms(int timeout_ms) const;

  private:
    JoinCommand join_command(KeyWay way, const std::filesystem::path& program) const;
    void spawn_engine(const EngineProcess& engine, KeyWay way);
    void close_input(const std::string& engine);
    void end_engine(const std::string& engine);
    /// The end of the process is no news. Returns false if it does not run.
    bool drop_engine(const std::string& engine);

    Topology topology_;
    bus::Credentials credentials_;
    std::filesystem::path folder_;
    std::optional<RemoteComputers> others_;
    Supervisor own_;
    std::optional<PollSet> polled_;
    int polled_link_ = -1;
    std::map<std::string, int> inputs_;  ///< Write ends by engine; their end ends `pxpl5 join`.
    std::vector<std::string> lost_;
    std::map<std::string, std::filesystem::path> engine_logs_;
    std::map<std::string, Death> ended_engines_;
    std::set<std::string> dropped_engines_;  ///< Their ends are no news.
    std::string join_line_;
    bool is_finished_ = false;
};

}  // namespace pxpl5::host
