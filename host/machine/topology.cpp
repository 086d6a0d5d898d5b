#include "host/machine/topology.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sched.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <memory>

#include "host/base/error.hpp"
#include "host/base/nearest.hpp"
#include "host/machine/computers/cluster_settings.hpp"
#include "host/machine/modelled_topology.hpp"
#include "host/machine/timing_section.hpp"
#include "host/machine/topology_file.hpp"

namespace pxpl5::host {

namespace {

[[noreturn]] void refuse(const std::string& text) {
    throw RequestError(ExitCode::usage, text);
}

/// A whole number of the plan and its range.
struct NumberKey {
    std::string_view name;
    int low, high;  ///< high 0: the most nodes of a role.
    int& (*in)(Topology&);
};

constexpr int max_frame_buffers = max_views;  // A view belongs to one frame buffer.
constexpr off_t max_file_bytes = off_t{1} << 20;
constexpr int max_memory_mib = 1 << 20;
constexpr int max_restarts = 1000;
constexpr int max_backoff_ms = 60'000;
constexpr int least_misses = 3;   // The host may see a beat two intervals late.
constexpr int least_stuck_s = 3;  // An idle node moves once per second.

constexpr std::array number_keys = {
    NumberKey{"gp.count", 1, 0, [](Topology& t) -> int& { return t.gp.count; }},
    NumberKey{"gp.memory_mib", 1, max_memory_mib,
              [](Topology& t) -> int& { return t.gp_memory_mib; }},
    NumberKey{"gp.slabs_per_set", 0, max_volume_voxels,
              [](Topology& t) -> int& { return t.slabs_per_set; }},
    NumberKey{"renderer.count", 1, 0, [](Topology& t) -> int& { return t.renderer.count; }},
    NumberKey{"frame_buffer.count", 1, max_frame_buffers,
              [](Topology& t) -> int& { return t.frame_buffer.count; }},
    NumberKey{"gp.restart.max", 0, max_restarts,
              [](Topology& t) -> int& { return t.gp.restart.max; }},
    NumberKey{"gp.restart.backoff_ms", 0, max_backoff_ms,
              [](Topology& t) -> int& { return t.gp.restart.backoff_ms; }},
    NumberKey{"renderer.restart.max", 0, max_restarts,
              [](Topology& t) -> int& { return t.renderer.restart.max; }},
    NumberKey{"renderer.restart.backoff_ms", 0, max_backoff_ms,
              [](Topology& t) -> int& { return t.renderer.restart.backoff_ms; }},
    NumberKey{"frame_buffer.restart.max", 0, max_restarts,
              [](Topology& t) -> int& { return t.frame_buffer.restart.max; }},
    NumberKey{"frame_buffer.restart.backoff_ms", 0, max_backoff_ms,
              [](Topology& t) -> int& { return t.frame_buffer.restart.backoff_ms; }},
    NumberKey{"wait", 0, max_computers, [](Topology& t) -> int& { return t.cluster.wait; }},
    NumberKey{"compress_below_mb_s", 0, 1'000'000,
              [](Topology& t) -> int& { return t.cluster.compress_below_mb_s; }},
    NumberKey{"heartbeat.interval_ms", 10, 60'000,
              [](Topology& t) -> int& { return t.heartbeat.interval_ms; }},
    NumberKey{"heartbeat.misses", 0, 1000, [](Topology& t) -> int& { return t.heartbeat.misses; }},
    NumberKey{"heartbeat.stuck_s", 0, 86'400,
              [](Topology& t) -> int& { return t.heartbeat.stuck_s; }},
#define PXPL5_TIMING_RING(field, name, unit, least, most) \
    NumberKey{name, least, most, [](Topology& t) -> int& { return t.ring.field; }},
#include "host/machine/timing_parameters.def"
};

struct RoleKey {
    std::string_view cpu, env, computer, restart_policy;
    RoleSettings& (*in)(Topology&);
};
constexpr std::array role_keys = {
    RoleKey{"gp.cpu", "gp.env", "gp.computer", "gp.restart.policy",
            [](Topology& t) -> RoleSettings& { return t.gp; }},
    RoleKey{"renderer.cpu", "renderer.env", "renderer.computer", "renderer.restart.policy",
            [](Topology& t) -> RoleSettings& { return t.renderer; }},
    RoleKey{"frame_buffer.cpu", "frame_buffer.env", "frame_buffer.computer",
            "frame_buffer.restart.policy",
            [](Topology& t) -> RoleSettings& { return t.frame_buffer; }},
};

int core_count() {
    cpu_set_t cores;
    const int count = sched_getaffinity(0, sizeof cores, &cores) == 0 ? CPU_COUNT(&cores) : 1;
    return std::clamp(count, 1, max_nodes_per_role);
}

void resolve_counts(Topology& topology) {
    for (RoleSettings* role : {&topology.gp, &topology.renderer}) {
        if (role->count == 0) {
            role->count = topology.fitted_to_cores = core_count();
        }
    }
}

/// A topology file may come from a stranger. LD_PRELOAD and its like would make it a program.
constexpr std::string_view allowed_begin = "PXPL5_";

void check_cores(const std::string& where, const RoleKey& key, const RoleSettings& role) {
    for (const int core : role.cpu) {
        if (core < 0 || core >= CPU_SETSIZE) {
            refuse(fmt::format("{}: {} names core {}, must be 0..{}", where, key.cpu, core,
                               CPU_SETSIZE - 1));
        }
    }
    for (const std::string& variable : role.env) {
        if (variable.find('=') == std::string::npos || variable.front() == '=') {
            refuse(fmt::format("{}: {} has '{}', must be NAME=value", where, key.env, variable));
        }
        if (!variable.starts_with(allowed_begin)) {
            refuse(
                fmt::format("{}: {} sets '{}', but may set only names that begin with {}. Set "
                            "other variables in the environment of pxpl5",
                            where, key.env, variable.substr(0, variable.find('=')), allowed_begin));
        }
    }
}

void check(Topology& topology, const std::string& where, int most_nodes) {
    for (const NumberKey& key : number_keys) {
        const int value = key.in(topology), high = key.high == 0 ? most_nodes : key.high;
        if (value < key.low || value > high) {
            refuse(
                fmt::format("{}: {} is {}, must be {}..{}", where, key.name, value, key.low, high));
        }
    }
    const auto check_limit = [&](const char* key, int value, int least) {
        if (value != 0 && value < least) {
            refuse(fmt::format("{}: {} is {}, must be 0 (off) or at least {}", where, key, value,
                               least));
        }
    };
    check_limit("heartbeat.misses", topology.heartbeat.misses, least_misses);
    check_limit("heartbeat.stuck_s", topology.heartbeat.stuck_s, least_stuck_s);
    for (const RoleKey& key : role_keys) {
        check_cores(where, key, key.in(topology));
    }
    if (topology.frame_buffer.restart.policy == RestartPolicy::degrade) {
        refuse(
            fmt::format("{}: frame_buffer.restart.policy is degrade, must be replace or end: "
                        "pictures need the frame buffer",
                        where));
    }
    check_timing(topology.timing, where);
    check_cluster(topology.cluster, where);
    for (const RoleKey& key : role_keys) {
        check_names(key.in(topology).computer, where, key.computer);
    }
}

template <typename Number>
Number whole_number(std::string_view key, std::string_view text) {
    Number value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size()) {
        refuse(fmt::format("{} is '{}', must be a whole number", key, text));
    }
    return value;
}

std::vector<int> core_list(std::string_view key, std::string_view text) {
    std::vector<int> cores;
    for (const std::string& word : words_of(text)) {
        cores.push_back(whole_number<int>(key, word));
    }
    return cores;
}

/// Returns false if `key` does not belong to a role's lists and words.
bool set_role_value(Topology& topology, std::string_view key, std::string_view value) {
    for (const RoleKey& role : role_keys) {
        if (key == role.cpu) {
            role.in(topology).cpu = core_list(key, value);
            return true;
        }
        if (key == role.env) {
            role.in(topology).env.emplace_back(value);
            return true;
        }
        if (key == role.computer) {
            role.in(topology).computer = words_of(value);
            return true;
        }
        if (key == role.restart_policy) {
            role.in(topology).restart.policy = value_named<RestartPolicy>(key, value);
            return true;
        }
    }
    return false;
}

[[noreturn]] void refuse_key(std::string_view key) {
    std::vector<std::string_view> known = {"computers",      "engine",    "engine_command",
                                           "listen",         "placement", "record",
                                           "ring.transport", "seed",      "vector_target"};
    for (const NumberKey& number : number_keys) {
        known.push_back(number.name);
    }
    for (const RoleKey& role : role_keys) {
        known.insert(known.end(), {role.cpu, role.env, role.computer, role.restart_policy});
    }
    const std::vector<std::string_view> timing = timing_names();
    known.insert(known.end(), timing.begin(), timing.end());
    std::sort(known.begin(), known.end());
    known.erase(std::unique(known.begin(), known.end()), known.end());
    refuse(fmt::format("--set: unknown key '{}'{}", key, did_you_mean(key, known)));
}

void set_value(Topology& topology, std::string_view key, std::string_view value) {
    const auto number = std::find_if(number_keys.begin(), number_keys.end(),
                                     [key](const NumberKey& k) { return k.name == key; });
    if (number != number_keys.end()) {
        number->in(topology) = whole_number<int>(key, value);
        topology.fitted_to_cores = key.ends_with(".count") ? 0 : topology.fitted_to_cores;
        mark_overridden(topology.timing, key);
    } else if (key == "seed") {
        topology.seed = whole_number<std::uint64_t>(key, value);
    } else if (key == "ring.transport") {
        topology.ring.transport = value_named<Transport>(key, value);
    } else if (key == "record") {
        topology.record = value_named<Recording>(key, value);
    } else if (key == "vector_target") {
        topology.vector_target = value_named<VectorTarget>(key, value);
    } else if (!set_cluster_value(topology.cluster, key, value) &&
               !override_timing(topology.timing, key, value) &&
               !set_role_value(topology, key, value)) {
        refuse_key(key);
    }
}

/// Gives a plan that was made by hand the paper's timing.
void complete_timing(Topology& topology) {
    if (topology.timing.empty()) {
        topology.timing = paper_timing();
    }
}

/// The text of a topology file, which may come from a stranger.
std::string read_text(const std::filesystem::path& path) {
    const auto refuse_file = [&path](const std::string& reason) {
        refuse(fmt::format("topology {}: {}", path.string(), reason));
    };
    // O_NONBLOCK: a FIFO without a writer would block here for ever.
    const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    if (file < 0) {
        refuse_file(fmt::format("cannot be read: {}", std::strerror(errno)));
    }
    const std::shared_ptr<void> closer(nullptr, [file](void*) { ::close(file); });
    struct stat facts {};
    if (fstat(file, &facts) != 0 || !S_ISREG(facts.st_mode)) {
        refuse_file("is no regular file");
    }
    if (facts.st_size > max_file_bytes) {
        refuse_file(fmt::format("has {} bytes, {} are the most", facts.st_size, max_file_bytes));
    }
    std::string text(static_cast<std::size_t>(facts.st_size), '\0');
    for (std::size_t done = 0; done < text.size();) {
        const ssize_t got = ::read(file, text.data() + done, text.size() - done);
        if (got == 0 || (got < 0 && errno != EINTR)) {
            refuse_file("cannot be read");
        }
        done += static_cast<std::size_t>(std::max<ssize_t>(got, 0));
    }
    return text;
}

std::filesystem::path find_named(const std::string& name) {
    std::vector<std::string> known;
    for (const std::filesystem::path& folder : topology_folders()) {
        std::error_code error;
        if (std::filesystem::exists(folder / (name + ".json"), error)) {
            return folder / (name + ".json");
        }
        for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
            if (entry.path().extension() == ".json") {
                known.push_back(entry.path().stem().string());
            }
        }
    }
    std::sort(known.begin(), known.end());
    const std::vector<std::string_view> names(known.begin(), known.end());
    std::error_code error;
    const bool is_file = std::filesystem::is_regular_file(name, error);
    refuse(fmt::format("no topology '{}'{}{}", name,
                       is_file ? fmt::format(" (for the file, give ./{})", name) : "",
                       did_you_mean(name, names)));
}

std::filesystem::path path_of(const std::string& name_or_path) {
    const std::filesystem::path given(name_or_path);
    const bool is_path = given.has_parent_path() || given.extension() == ".json";
    return is_path ? given : find_named(name_or_path);
}

/// Applies one override.
void change(Topology& topology, std::string_view assignment, int most_nodes) {
    const std::size_t equals = assignment.find('=');
    if (equals == std::string_view::npos) {
        refuse(fmt::format("--set {}: must be key=value", assignment));
    }
    complete_timing(topology);
    set_value(topology, assignment.substr(0, equals), assignment.substr(equals + 1));
    // The figures of a modelled machine must not depend on this computer's cores.
    if (most_nodes == max_nodes_per_role) resolve_counts(topology);
    check(topology, fmt::format("--set {}", assignment), most_nodes);
}

Topology parse(std::string_view text, const std::string& file,
               const std::vector<std::string>& overrides, int most_nodes) {
    Topology topology = read_topology_file(text, file);
    topology.name = std::filesystem::path(file).stem().string();
    complete_timing(topology);
    resolve_counts(topology);
    check(topology, file, most_nodes);
    check_trust(topology.cluster, file, overrides);
    for (const std::string& assignment : overrides) {
        change(topology, assignment, most_nodes);
    }
    return topology;
}

}  // namespace

std::string size_text(const Topology& topology) {
    const auto counted = [](int count, std::string_view word) {
        return fmt::format("{} {}{}", count, word, count == 1 ? "" : "s");
    };
    const std::string size = fmt::format("{}, {}", counted(topology.gp.count, "GP"),
                                         counted(topology.renderer.count, "Renderer"));
    return topology.fitted_to_cores == 0
               ? size
               : fmt::format("{}, fitted to {}", size, counted(topology.fitted_to_cores, "core"));
}

Topology with_nodes(Topology topology, int more_gps, int more_renderers) {
    topology.gp.count += more_gps;
    topology.renderer.count += more_renderers;
    complete_timing(topology);
    topology.fitted_to_cores = more_gps == 0 && more_renderers == 0 ? topology.fitted_to_cores : 0;
    check(topology, "the machine", max_nodes_per_role);
    return topology;
}

void apply_override(Topology& topology, std::string_view assignment) {
    change(topology, assignment, max_nodes_per_role);
}

void apply_modelled_override(Topology& topology, std::string_view assignment) {
    change(topology, assignment, max_modelled_nodes);
}

Topology parse_topology(std::string_view text, const std::string& file,
                        const std::vector<std::string>& overrides) {
    return parse(text, file, overrides, max_nodes_per_role);
}

Topology load_topology(const std::string& name_or_path, const std::vector<std::string>& overrides) {
    const std::filesystem::path path = path_of(name_or_path);
    return parse(read_text(path), path.string(), overrides, max_nodes_per_role);
}

Topology load_modelled_topology(const std::string& name_or_path,
                                const std::vector<std::string>& overrides) {
    const std::filesystem::path path = path_of(name_or_path);
    return parse(read_text(path), path.string(), overrides, max_modelled_nodes);
}

std::vector<std::filesystem::path> topology_folders() {
    std::vector<std::filesystem::path> folders;
    if (const char* given = std::getenv("PXPL5_TOPOLOGIES"); given != nullptr) {
        folders.emplace_back(given);
    }
    folders.emplace_back(PXPL5_TOPOLOGY_FOLDER);
    std::error_code error;
    const auto program = std::filesystem::read_symlink("/proc/self/exe", error);
    folders.push_back(program.parent_path().parent_path() / "share/pxpl5/topologies");
    return folders;
}

}  // namespace pxpl5::host
