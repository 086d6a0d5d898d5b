#include "host/machine/topology_file.hpp"

#include <flatbuffers/idl.h>
#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <memory>

#include "host/base/error.hpp"
#include "host/base/nearest.hpp"
#include "host/machine/computers/cluster_settings.hpp"
#include "host/machine/timing_section.hpp"
#include "host/machine/topology_schema.hpp"
#include "topology_generated.h"

namespace pxpl5::host {

namespace {

/// Every key of the schema, to find the nearest to a misspelled key.
std::vector<std::string_view> known_keys(const flatbuffers::Parser& parser) {
    std::vector<std::string_view> keys;
    for (const flatbuffers::StructDef* table : parser.structs_.vec) {
        for (const flatbuffers::FieldDef* field : table->fields.vec) {
            keys.push_back(field->name);
        }
    }
    std::sort(keys.begin(), keys.end());
    keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
    return keys;
}

/// "; it belongs in 'roles'" for a key that belongs in another place.
std::string home_of(const flatbuffers::Parser& parser, const std::string& key) {
    for (const flatbuffers::StructDef* owner : parser.structs_.vec) {
        if (owner->fields.Lookup(key) == nullptr) {
            continue;
        }
        for (const flatbuffers::StructDef* table : parser.structs_.vec) {
            for (const flatbuffers::FieldDef* field : table->fields.vec) {
                if (field->value.type.struct_def == owner) {
                    return fmt::format("; it belongs in '{}'", field->name);
                }
            }
        }
        return "; it belongs at the top level";
    }
    return did_you_mean(key, known_keys(parser));
}

/// The parser's own text is "<absolute path>:<line>: <column>: error: <what>".
[[noreturn]] void refuse(const flatbuffers::Parser& parser, const std::string& file) {
    constexpr std::string_view mark = "error: ", unknown = "unknown field: ";
    const std::string& error = parser.error_;
    const std::size_t at = error.find(mark);
    std::string what = at == std::string::npos ? error : error.substr(at + mark.size());
    if (what.starts_with(unknown)) {
        const std::string key = what.substr(unknown.size());
        what = fmt::format("unknown key '{}'{}", key, home_of(parser, key));
    }
    const std::size_t place =
        error.rfind(':', at == std::string::npos ? at : error.rfind(':', at) - 1);
    const std::size_t line = place == std::string::npos ? 0 : error.rfind(':', place - 1) + 1;
    throw RequestError(ExitCode::usage,
                       fmt::format("{}:{}: {}", file, error.substr(line, place - line), what));
}

template <typename Role>
void copy_role(const Role& from, RoleSettings& to) {
    const config::RestartT restart = from.restart ? *from.restart : config::RestartT{};
    to = {from.count,
          from.env,
          from.cpu,
          from.computer,
          {restart.policy, restart.max, restart.backoff_ms}};
}

/// The parser takes any number for an enumeration.
template <typename Enum>
void check_enum(const std::string& file, std::string_view key, Enum value,
                std::string_view values) {
    if (value > Enum::MAX) {
        throw RequestError(ExitCode::usage, fmt::format("{}: {} is {}, must be {}", file, key,
                                                        static_cast<int>(value), values));
    }
}

std::vector<TimingValue> timing_of(const config::MachineT& machine, const std::string& file) {
    std::vector<TimingValue> timing;
    for (const auto& entry : machine.timing) {
        if (!entry->provenance) {
            throw RequestError(ExitCode::usage,
                               fmt::format("{}: {} has no provenance", file, entry->name));
        }
        check_enum(file, entry->name + "'s provenance", *entry->provenance,
                   "published, recalled, derived, ours or fitted");
        timing.push_back(
            {entry->name, entry->value, entry->word, entry->unit, *entry->provenance, entry->note});
    }
    return timing;
}

/// The nearest known name to an unknown one, with the unknown name's line.
void check_timing_names(const std::vector<TimingValue>& timing, std::string_view text,
                        const std::string& file) {
    const std::vector<std::string_view> known = timing_names();
    for (const TimingValue& entry : timing) {
        if (std::find(known.begin(), known.end(), entry.name) == known.end()) {
            const std::size_t at = text.find('"' + entry.name + '"');
            const auto before = text.substr(0, std::min(at, text.size()));
            throw RequestError(ExitCode::usage,
                               fmt::format("{}:{}: unknown parameter '{}'{}", file,
                                           1 + std::count(before.begin(), before.end(), '\n'),
                                           entry.name, did_you_mean(entry.name, known)));
        }
    }
}

std::vector<std::unique_ptr<config::TimingValueT>> timing_table(
    const std::vector<TimingValue>& timing) {
    std::vector<std::unique_ptr<config::TimingValueT>> table;
    for (const TimingValue& value : timing) {
        auto entry = std::make_unique<config::TimingValueT>();
        entry->name = value.name;
        entry->value = value.value;
        entry->word = value.word;
        entry->unit = value.unit;
        entry->provenance = value.provenance;
        entry->note = value.note;
        table.push_back(std::move(entry));
    }
    return table;
}

ClusterSettings cluster_of(const config::MachineT& machine) {
    ClusterSettings cluster;
    cluster.engine = machine.engine;
    cluster.command = machine.engine_command;
    for (const auto& computer : machine.computers) {
        cluster.computers.push_back({computer->name, computer->slots});
    }
    cluster.wait = machine.wait;
    cluster.compress_below_mb_s = machine.compress_below_mb_s;
    cluster.placement = machine.placement;
    set_listen(cluster, machine.listen);
    return cluster;
}

void write_cluster(const ClusterSettings& cluster, config::MachineT& machine) {
    machine.engine = cluster.engine;
    machine.engine_command = cluster.command;
    for (const ComputerSlots& computer : cluster.computers) {
        auto entry = std::make_unique<config::ComputerT>();
        entry->name = computer.name;
        entry->slots = computer.slots;
        machine.computers.push_back(std::move(entry));
    }
    machine.wait = cluster.wait;
    machine.compress_below_mb_s = cluster.compress_below_mb_s;
    machine.placement = cluster.placement;
    machine.listen = listen_text(cluster);
}

Topology plan_of(const config::MachineT& machine) {
    Topology plan;
    const config::RolesT roles = machine.roles ? *machine.roles : config::RolesT{};
    const config::GpT gp = roles.gp ? *roles.gp : config::GpT{};
    copy_role(gp, plan.gp);
    plan.gp_memory_mib = gp.memory_mib;
    plan.slabs_per_set = gp.slabs_per_set;
    copy_role(roles.renderer ? *roles.renderer : config::RendererT{}, plan.renderer);
    copy_role(roles.frame_buffer ? *roles.frame_buffer : config::FrameBufferT{}, plan.frame_buffer);
    const config::RingT ring = machine.ring ? *machine.ring : config::RingT{};
    plan.ring = {ring.channels, ring.transport, ring.channel_mb_s, ring.hop_ns};
    const config::HeartbeatT beat = machine.heartbeat ? *machine.heartbeat : config::HeartbeatT{};
    plan.heartbeat = {beat.interval_ms, beat.misses, beat.stuck_s};
    plan.cluster = cluster_of(machine);
    plan.seed = machine.seed;
    plan.record = machine.record;
    plan.vector_target = machine.vector_target;
    return plan;
}

template <typename RoleTable>
std::unique_ptr<RoleTable> role_table(const RoleSettings& role) {
    auto table = std::make_unique<RoleTable>();
    table->count = role.count;
    table->env = role.env;
    table->cpu = role.cpu;
    table->computer = role.computer;
    table->restart = std::make_unique<config::RestartT>();
    table->restart->policy = role.restart.policy;
    table->restart->max = role.restart.max;
    table->restart->backoff_ms = role.restart.backoff_ms;
    return table;
}

void learn_schema(flatbuffers::Parser& parser) {
    [[maybe_unused]] const bool valid = parser.Parse(topology_schema);
    assert(valid);
}

}  // namespace

std::vector<TimingValue> paper_timing() {
    return read_topology_file(paper_topology, "paper-1993.json").timing;
}

Topology read_topology_file(std::string_view text, const std::string& file) {
    flatbuffers::Parser parser;
    learn_schema(parser);
    // Parse() would take a schema, too, whose root need not be a machine.
    if (!parser.ParseJson(std::string(text).c_str(), file.c_str())) {
        refuse(parser, file);
    }
    const auto machine = config::UnPackMachine(parser.builder_.GetBufferPointer());
    if (machine->ring) {
        check_enum(file, "ring.transport", machine->ring->transport, "ipc or tcp");
    }
    check_enum(file, "record", machine->record, "off, flight or full");
    check_enum(file, "engine", machine->engine, "local, slurm, ssh, mpirun, command or wait");
    check_enum(file, "placement", machine->placement, "pack or spread");
    check_enum(file, "vector_target", machine->vector_target, "best, sse4, avx2 or avx512");
    Topology plan = plan_of(*machine);
    for (const auto& [role, settings] : {std::pair{"gp", &plan.gp},
                                         {"renderer", &plan.renderer},
                                         {"frame_buffer", &plan.frame_buffer}}) {
        check_enum(file, fmt::format("{}.restart.policy", role), settings->restart.policy,
                   "replace, degrade or end");
    }
    plan.timing = timing_of(*machine, file);
    check_timing_names(plan.timing, text, file);
    return plan;
}

std::string resolved_json(const Topology& topology) {
    config::MachineT machine;
    machine.roles = std::make_unique<config::RolesT>();
    machine.roles->gp = role_table<config::GpT>(topology.gp);
    machine.roles->gp->memory_mib = topology.gp_memory_mib;
    machine.roles->gp->slabs_per_set = topology.slabs_per_set;
    machine.roles->renderer = role_table<config::RendererT>(topology.renderer);
    machine.roles->frame_buffer = role_table<config::FrameBufferT>(topology.frame_buffer);
    machine.ring = std::make_unique<config::RingT>();
    machine.ring->channels = topology.ring.channels;
    machine.ring->transport = topology.ring.transport;
    machine.ring->channel_mb_s = topology.ring.channel_mb_s;
    machine.ring->hop_ns = topology.ring.hop_ns;
    write_cluster(topology.cluster, machine);
    machine.heartbeat = std::make_unique<config::HeartbeatT>();
    machine.heartbeat->interval_ms = topology.heartbeat.interval_ms;
    machine.heartbeat->misses = topology.heartbeat.misses;
    machine.heartbeat->stuck_s = topology.heartbeat.stuck_s;
    machine.timing = timing_table(topology.timing.empty() ? paper_timing() : topology.timing);
    machine.seed = topology.seed;
    machine.record = topology.record;
    machine.vector_target = topology.vector_target;

    flatbuffers::FlatBufferBuilder builder;
    builder.Finish(config::CreateMachine(builder, &machine));
    flatbuffers::IDLOptions options;
    options.strict_json = true;
    options.output_default_scalars_in_json = true;
    flatbuffers::Parser parser(options);
    learn_schema(parser);
    std::string text;
    flatbuffers::GenerateText(parser, builder.GetBufferPointer(), &text);
    return text;
}

}  // namespace pxpl5::host
