#include "host/machine/roster.hpp"

#include <fmt/core.h>

#include <cassert>
#include <memory>

namespace pxpl5::host {

namespace {

namespace schema = bus::schema;
using schema::Role;

constexpr std::uint64_t bytes_per_mib = std::uint64_t{1} << 20;

}  // namespace

std::string RosterEntry::name() const {
    switch (role) {
        case Role::host:
            return "host";
        case Role::gp:
            return fmt::format("gp-{}", index);
        case Role::renderer:
            return fmt::format("renderer-{}", index);
        case Role::frame_buffer:
            return fmt::format("framebuffer-{}", index);
        case Role::io:
            return fmt::format("io-{}", index);
    }
    return fmt::format("node-{}", id);
}

std::string RosterEntry::binary() const {
    switch (role) {
        case Role::host:
            return "";
        case Role::gp:
            return "pxpl5-gp";
        case Role::renderer:
            return "pxpl5-renderer";
        case Role::frame_buffer:
            return "pxpl5-framebuffer";
        case Role::io:
            return "pxpl5-io";
    }
    return "";
}

Roster roster_of(const Topology& topology) {
    Roster roster(1);
    for (const Role role : {Role::gp, Role::renderer, Role::frame_buffer}) {
        for (int index = 0; index < settings_of(topology, role).count; ++index) {
            roster.push_back({static_cast<bus::NodeId>(roster.size()), role, index, "", 0});
        }
    }
    return roster;
}

std::vector<bus::NodeId> ids_of(const Roster& roster, Role role) {
    std::vector<bus::NodeId> ids;
    for (const RosterEntry& entry : roster) {
        if (entry.role == role) {
            ids.push_back(entry.id);
        }
    }
    return ids;
}

std::vector<MachineNode> nodes_of(const Roster& roster) {
    std::vector<MachineNode> nodes;
    for (const RosterEntry& entry : roster) {
        nodes.push_back({entry.id, entry.role, entry.name()});
    }
    return nodes;
}

bus::Payload topology_message(const Roster& roster, const Topology& topology) {
    schema::TopologyT message;
    for (const RosterEntry& entry : roster) {
        auto node = std::make_unique<schema::NodeInfoT>();
        node->id = entry.id;
        node->role = entry.role;
        node->index = static_cast<std::uint16_t>(entry.index);
        node->endpoint = entry.endpoint;
        node->near_endpoint = entry.near_endpoint;
        node->computer = static_cast<std::uint16_t>(entry.place);
        message.nodes.push_back(std::move(node));
    }
    message.gp_memory_bytes = static_cast<std::uint64_t>(topology.gp_memory_mib) * bytes_per_mib;
    message.ring_channels = static_cast<std::uint16_t>(topology.ring.channels);
    message.ring_bytes_per_s = topology.ring.channel_bytes_per_s();
    message.ring_hop_ns = static_cast<std::uint32_t>(topology.ring.hop_ns);
    message.recording = static_cast<Recording>(topology.record);
    return bus::pack(message);
}

const RoleSettings& settings_of(const Topology& topology, Role role) {
    assert(role == Role::gp || role == Role::renderer || role == Role::frame_buffer);
    return role == Role::gp         ? topology.gp
           : role == Role::renderer ? topology.renderer
                                    : topology.frame_buffer;
}

bus::Payload shutdown_message() {
    schema::ShutdownT message;
    message.reason = "the host is done";
    return bus::pack(message);
}

}  // namespace pxpl5::host
