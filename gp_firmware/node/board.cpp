#include "gp_firmware/node/board.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "gp_firmware/node/messages.hpp"
#include "gp_firmware/render/surface_memory.hpp"
#include "gp_firmware/surface/marching_cubes.hpp"
#include "ringbus/node.hpp"

namespace pxpl5::gp {

namespace {

namespace schema = bus::schema;
using bus::NodeFault;
using schema::FaultCode;

/// Ids of all nodes of one role, by index.
std::vector<bus::NodeId> nodes_of(const schema::Topology& topology, schema::Role role) {
    std::vector<std::pair<std::uint16_t, bus::NodeId>> found;
    for (const auto* node : *topology.nodes()) {
        if (node->role() == role) {
            found.emplace_back(node->index(), node->id());
        }
    }
    std::ranges::sort(found);
    std::vector<bus::NodeId> ids;
    for (const auto& [index, id] : found) {
        ids.push_back(id);
    }
    return ids;
}

}  // namespace

Machine machine_of(const bus::Message& message) {
    const auto& topology = *message.as<schema::Topology>();
    Machine machine;
    machine.memory_bytes = topology.gp_memory_bytes();
    machine.keeps_origins = topology.recording() != Recording::off;
    machine.gps = nodes_of(topology, schema::Role::gp);
    machine.renderers = nodes_of(topology, schema::Role::renderer);
    machine.frame_buffers = nodes_of(topology, schema::Role::frame_buffer);
    const bus::NodeId self = message.header().destination();
    const auto here = std::ranges::find(machine.gps, self);
    if (here == machine.gps.end()) {
        throw NodeFault(FaultCode::bad_input,
                        fmt::format("node {} is not one of the {} GPs in the topology", self,
                                    machine.gps.size()));
    }
    if (machine.gps.size() > static_cast<std::size_t>(max_nodes_per_role)) {
        throw NodeFault(FaultCode::bad_input,
                        fmt::format("the topology has {} GPs, but at most {} are possible",
                                    machine.gps.size(), max_nodes_per_role));
    }
    machine.share = {static_cast<int>(here - machine.gps.begin()),
                     static_cast<int>(machine.gps.size())};
    return machine;
}

void drop_surface(Board& board, std::uint16_t surface) {
    const auto held = board.surfaces.find(surface);
    for (const SlabMesh& mesh : held->second.slabs) {
        board.memory.release(size_bytes(mesh));
    }
    drop_simplified(held->second, board.memory);
    board.surfaces.erase(held);
}

void drop_content(Board& board, Freed freed) {
    while (!board.surfaces.empty()) {
        drop_surface(board, board.surfaces.begin()->first);
    }
    board.store.reset();
    board.is_scene = false;
    board.scratch = {};
    board.restored = {};
    board.planes = {};
    board.frame.drawing = {};
    board.frame.programs = {};
    if (freed == Freed::returned) {
        return_freed_memory();
    }
}

schema::VolumeReadyT volume_ready(const Board& board) {
    schema::VolumeReadyT ready;
    ready.volume = *board.volume;
    ready.memory_bytes = board.memory.used_bytes();
    ready.elapsed_us = to_us(Clock::now() - board.volume_since);
    return ready;
}

}  // namespace pxpl5::gp
