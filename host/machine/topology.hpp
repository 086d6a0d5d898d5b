// The plan of a machine: its nodes, and the ring between them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "generated/vocabulary.hpp"
#include "isa/contract/vector_target.hpp"

namespace pxpl5::host {

/// Settings for the death of a node.
struct RestartSettings {
    RestartPolicy policy = RestartPolicy::replace;
    int max = 3;           ///< Restarts for one command or picture; then the machine ends.
    int backoff_ms = 100;  ///< Pause before a restart within a minute of another; it doubles.
};

/// All nodes of one role.
struct RoleSettings {
    int count = 0;                 ///< 1..64; in a file, 0 means as many as this process has cores.
    std::vector<std::string> env;  ///< "NAME=value", added to the host's environment.
    std::vector<int> cpu;          ///< Node n runs on core cpu[n mod size]; empty: any core.
    std::vector<std::string> computer = {};  ///< Node n runs on computer[n mod size], by name.
    RestartSettings restart = {};
};

struct RingSettings {
    int channels = 8;
    Transport transport = Transport::ipc;
    int channel_mb_s = 80;  ///< 10^6 bytes per second of one channel, modelled.
    int hop_ns = 50;        ///< From one node's ring interface to the next, modelled.

    std::uint64_t channel_bytes_per_s() const {
        return static_cast<std::uint64_t>(channel_mb_s) * 1'000'000;
    }
};

/// When the host ends a node that does not answer.
struct HeartbeatSettings {
    int interval_ms = 1000;  ///< Between two beats of a node, and between two looks of the host.
    int misses = 10;         ///< Missed beats after which a node is ended; 0: never.
    int stuck_s = 300;       ///< Time without progress after which a node is ended; 0: never.

    std::int64_t silence_ms() const { return std::int64_t{interval_ms} * misses; }
};

/// A computer beside the host's own.
struct ComputerSlots {
    std::string name;
    int slots = 0;  ///< Nodes that it takes; 0: as many as its cores.
};

/// The computers of a machine, and what starts pxpl5 on them.
struct ClusterSettings {
    Engine engine = Engine::local;
    std::vector<std::string> command;  ///< The words of Engine::command.
    std::vector<ComputerSlots> computers;
    int wait = 0;  ///< Computers that join; 0: as many as `computers`.
    Placement placement = Placement::pack;
    /// If the network is slower, messages between computers are compressed. 10^6 bytes per second;
    /// 0: never.
    int compress_below_mb_s = 100;
    std::string listen;    ///< Address at which the host listens for computers; empty: all.
    int listen_port = 0;   ///< Port where computers join; 0: a free one.
    std::string key_file;  ///< The user's file with the key of the machine. Not a key.
    std::vector<std::string> lost;  ///< Names of computers that are left out. Not a key.

    /// True if nodes may run on other computers.
    bool is_used() const { return engine != Engine::local; }
};

/// A parameter of the timing model, as a file gives it. timing_section.hpp has the names.
struct TimingValue {
    std::string name;             ///< "gp.edge_cycles"
    std::optional<double> value;  ///< None for words, and where section `ring` has it.
    std::string word;             ///< "even"; empty for numbers.
    std::string unit;             ///< Empty for words.
    Provenance provenance = Provenance::ours;
    std::string note;
};

/// A resolved plan: counts are the numbers of processes.
struct Topology {
    std::string name;  ///< The file's name without folder and suffix.
    RoleSettings gp, renderer, frame_buffer;
    int fitted_to_cores = 0;   ///< Value of the counts that were 0; 0 if none was 0.
    int gp_memory_mib = 4096;  ///< Local memory of each GP.
    int slabs_per_set = 0;     ///< Adjacent slabs that belong to one GP; 0: by the volume's size.
    RingSettings ring;
    HeartbeatSettings heartbeat;
    ClusterSettings cluster;
    std::vector<TimingValue> timing;  ///< All values; those of paper-1993 if the file has none.
    Recording record = Recording::off;
    VectorTarget vector_target = VectorTarget::best;  ///< The same for all nodes.
    std::uint64_t seed = 0;  ///< Seed of random choices: the simulated order of arrival.
};

/// Reads a machine by name ("paper-1993": a file of the topologies folder) or by path, applies
/// `overrides` ("gp.count=4", see apply_override), resolves counts of 0 and checks the ranges.
///
/// Throws RequestError (usage): no such machine (names the known ones); an unknown key (file, line,
/// nearest key); a value out of range (key, value and range).
Topology load_topology(const std::string& name_or_path,
                       const std::vector<std::string>& overrides = {});

/// The same for the text of a file. `file` is for messages only.
Topology parse_topology(std::string_view text, const std::string& file,
                        const std::vector<std::string>& overrides = {});

/// Sets one value: "gp.count=4", "gp.memory_mib=8", "gp.cpu=0,1", "renderer.env=A=b",
/// "ring.transport=tcp", "heartbeat.misses=0", "gp.restart.policy=end", "record=full",
/// "vector_target=sse4", "seed=7", "gp.edge_cycles=140", "share=own", "engine=ssh",
/// "computers=n1,n2:8", "renderer.computer=n1". A count of 0 is resolved.
/// Throws RequestError (usage).
void apply_override(Topology& topology, std::string_view assignment);

/// The plan with more or fewer GPs and Renderers. Throws RequestError (usage) if a count is out of
/// range.
Topology with_nodes(Topology topology, int more_gps, int more_renderers);

/// The machine's size for messages: "2 GPs, 2 Renderers, fitted to 2 cores".
std::string size_text(const Topology& topology);

/// The plan as a topology file that load_topology reads back to the same plan.
std::string resolved_json(const Topology& topology);

/// Folders of named machines, in order of search: PXPL5_TOPOLOGIES if set, the folder in the source
/// tree of this build, ../share/pxpl5/topologies from the executable.
std::vector<std::filesystem::path> topology_folders();

}  // namespace pxpl5::host
