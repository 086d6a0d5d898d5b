// A running machine of real processes.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "host/base/state_folder.hpp"
#include "host/machine/port.hpp"
#include "host/machine/topology.hpp"

namespace pxpl5::host {

struct MachineOptions {
    std::filesystem::path binaries;  ///< Folder of pxpl5-gp and the others; empty: the host's own.
    std::filesystem::path run_base = default_run_base();  ///< Parent of the run folder.
    int keep_runs = 0;                  ///< Run folders kept there, this one included; 0: all.
    int start_timeout_s = 60;           ///< Limit for Hello from all nodes, and for Connected.
    bool is_restart = false;            ///< Waits minutes for computers of a queue, not an hour.
    int drain_ms = 5000;                ///< Limit for nodes to end by themselves in shutdown().
    int io_memory_mib = 16384;          ///< Address space of the io process.
    int io_cpu_s = 300;                 ///< CPU time of the io process.
    std::vector<std::string> io_allow;  ///< Where headers may name data files, beside their folder.
    bool io_sandbox = true;             ///< Confines each io process to the files of its request.
    /// Ids of io processes, used in turn. Messages of the process that had an id before have come.
    unsigned io_ids = 1024;
    bool insecure_tcp = false;  ///< Lets ring.transport=tcp work without encryption.
};

/// Launches, supervises and ends the processes of one machine. Use it from the main thread: the
/// kernel ends the children when the thread that started them ends.
///
/// During its life, SIGINT, SIGTERM and SIGHUP end the machine: pump() and wait_readable() throw
/// MachineError (128 + signal), but see allow_cancel(). SIGPIPE and SIGXFSZ stay ignored
/// afterwards: write calls return the error.
class Machine final : public MachinePort {
  public:
    /// Returns when every node knows every other node. Throws MachineError if a node could not
    /// start, died, has another build or did not answer in time. The error names the node, and no
    /// process is left.
    Machine(const Topology& topology, const MachineOptions& options);
    /// Ends all processes, without waiting for unfinished work.
    ~Machine() override;
    Machine(const Machine&) = delete;
    Machine& operator=(const Machine&) = delete;

    const std::vector<bus::NodeId>& gp_ids() const override;
    const std::vector<bus::NodeId>& renderer_ids() const override;
    const std::vector<bus::NodeId>& frame_buffer_ids() const override;
    std::vector<MachineNode> nodes() const override;
    bus::Traffic traffic() const override;
    void kill(bus::NodeId id) override;
    RestartSettings restart_of(const std::string& node) const override;
    /// Makes a run folder of its own. Computers that have joined stay and get nodes.
    void start_again(const NodeChange& change, int pause_ms = 0) override;
    std::vector<MachineComputer> computers() const override;
    void use_computers(const std::string& name) override;
    bool release_computer(const std::string& name) override;
    std::string join_line() override;
    void tell_computers(std::function<void(const std::string&)> tell) override;
    void send(bus::NodeId to, bus::Payload payload) override;
    flatbuffers::Allocator* body_allocator() override;
    bool takes_more(bus::NodeId to) const override;
    void pump(const std::function<void(const bus::Message&)>& take,
              const std::function<bool()>& done) override;
    void wait_readable(int fd) override;
    void prepare_io() override;
    bus::NodeId start_io(ExitCode on_death = ExitCode::bad_data) override;
    void release_io() override;
    std::vector<std::string> io_folders() const override;
    void allow_cancel(bool allowed) override;
    void name_work(const std::string& work) override;
    void name_surfaces(std::function<std::string(std::uint32_t)> name_of) override;
    void watch(int fd, std::function<bool()> give_up) override;
    void tell_suspects(std::function<void(const std::string&)> tell) override;
    bool is_recording() const override;
    int slabs_per_set() const override;
    void allow_give_up(bool allowed) override;
    void cancel_on_interrupt(bool allowed) override;
    SavedTraces save_traces() override;
    SavedTraces save_traces_after_fault() override;

    /// Sends Shutdown to every node and waits until all have ended. Throws MachineError with the
    /// name of the first node that failed. The machine cannot be used afterwards.
    void shutdown();

    /// The folder of config.resolved.json, manifest.json, <role>-<index>.log of every process and,
    /// once they are written, traces/<role>-<index>.mcap of every node.
    const std::filesystem::path& run_folder() const;

    /// "gp-3", for messages about a node.
    std::string node_name(bus::NodeId id) const;

    struct Process {
        std::string name;
        int pid = 0;
    };
    /// The nodes in ring order with the host, without the io process.
    std::vector<Process> processes() const;

  private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

}  // namespace pxpl5::host
