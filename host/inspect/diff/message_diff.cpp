#include "host/inspect/diff/message_diff.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <vector>

namespace pxpl5::host::inspect {

namespace {

namespace schema = bus::schema;
using bus::Body;
using Entries = std::vector<const bus::trace::Entry*>;

/// True if a message of the kind is the same whenever the same is asked of the same machine.
bool is_repeatable(Body kind) {
    constexpr Body kinds[] = {Body::VolumeHeader,  Body::VolumeEnd,      Body::SetSurface,
                              Body::RemoveSurface, Body::MeshPart,       Body::DrawFrame,
                              Body::BeginFrame,    Body::RegionPrograms, Body::RegionPixels,
                              Body::FrameDone,     Body::SceneBegin,     Body::ScenePart,
                              Body::SceneEnd};
    return std::ranges::find(kinds, kind) != std::end(kinds);
}

/// The repeatable messages by sender.
std::map<bus::NodeId, Entries> by_sender(const NodeTrace& node) {
    std::map<bus::NodeId, Entries> entries;
    for (const bus::trace::Entry& entry : node.entries) {
        if (is_repeatable(entry.kind())) {
            entries[entry.header.source()].push_back(&entry);
        }
    }
    return entries;
}

/// The first of these that differs, from 0; nothing if one list only goes on for longer.
std::optional<std::size_t> first_of(const NodeTrace& a, const Entries& in_a, const NodeTrace& b,
                                    const Entries& in_b) {
    for (std::size_t i = 0; i < std::min(in_a.size(), in_b.size()); ++i) {
        if (in_a[i]->kind() != in_b[i]->kind() ||
            !std::ranges::equal(a.load(*in_a[i]).bytes(), b.load(*in_b[i]).bytes())) {
            return i;
        }
    }
    return std::nullopt;
}

}  // namespace

std::optional<std::string> first_message_difference(const RecordedRun& a, const RecordedRun& b) {
    if (a.gp_count() != b.gp_count() || a.renderer_count() != b.renderer_count() ||
        a.frame_buffer_count() != b.frame_buffer_count()) {
        return std::nullopt;
    }
    for (const auto& [id, node_a] : a.nodes()) {
        const auto node_b = b.nodes().find(id);
        if (node_b == b.nodes().end() || node_a.info.dropped != 0 ||
            node_b->second.info.dropped != 0) {
            continue;
        }
        const auto from_a = by_sender(node_a), from_b = by_sender(node_b->second);
        for (const auto& [sender, in_a] : from_a) {
            const auto in_b = from_b.find(sender);
            if (in_b == from_b.end()) {
                continue;
            }
            if (const auto i = first_of(node_a, in_a, node_b->second, in_b->second)) {
                return fmt::format("message {} from {} to {} differs: {} in A, {} in B", *i + 1,
                                   a.node_name(sender), a.node_name(id),
                                   bus::kind_name(in_a[*i]->kind()),
                                   bus::kind_name(in_b->second[*i]->kind()));
            }
        }
    }
    return std::nullopt;
}

std::optional<std::string> slice_difference(const RecordedRun& a, const RecordedRun& b,
                                            std::uint32_t frame) {
    const auto in_a = a.volume(frame), in_b = b.volume(frame);
    if (!in_a || !in_b) {
        return std::nullopt;
    }
    const auto& shape = *in_a->header.as<schema::VolumeHeader>();
    for (int z = 0; z < static_cast<int>(std::min(in_a->slice.size(), in_b->slice.size())); ++z) {
        for (int y = 0; y < static_cast<int>(shape.ny()); ++y) {
            for (int x = 0; x < static_cast<int>(shape.nx()); ++x) {
                const auto p = in_a->value(x, y, z), q = in_b->value(x, y, z);
                if (p && q && *p != *q) {
                    return fmt::format("voxel ({}, {}, {}) is {} in A, {} in B", x, y, z, *p, *q);
                }
            }
        }
    }
    return std::nullopt;
}

}  // namespace pxpl5::host::inspect
