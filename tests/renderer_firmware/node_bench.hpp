// Drives a Renderer's node with hand-made messages.
#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <string>

#include "generated/vocabulary.hpp"
#include "renderer_firmware/node.hpp"
#include "tests/renderer_firmware/triangles.hpp"

namespace pxpl5::test {

namespace schema = bus::schema;
using schema::Body;

using WordList = std::vector<std::uint32_t>;
inline constexpr bus::NodeId first_gp = 1, first_renderer = 10, frame_buffer = 20;
inline constexpr std::size_t tile = 128 * 128;

struct RendererOutbox final : bus::Outbox {
    using bus::Outbox::send;
    struct Sent {
        bus::NodeId to;
        bus::Payload payload;
    };
    void send(bus::NodeId to, bus::Payload payload) override {
        if (payload.kind() == refused) {
            throw bus::NodeFault(schema::FaultCode::out_of_memory, "the receiver is full");
        }
        sent.push_back({to, std::move(payload)});
    }
    std::vector<Sent> sent;
    Body refused = Body::NONE;  ///< Sending this kind throws.
};

struct SegmentWords {
    std::uint16_t surface;
    std::uint32_t slab;
    WordList words;
};
struct RegionWords {
    std::uint16_t region;
    std::vector<SegmentWords> segments;
};

inline bus::Payload programs(std::uint32_t frame, int gp, const std::vector<RegionWords>& regions) {
    schema::RegionProgramsT body;
    body.frame = frame;
    body.gp = static_cast<std::uint16_t>(gp);
    for (const RegionWords& region : regions) {
        auto program = std::make_unique<schema::RegionProgramT>();
        program->region = region.region;
        for (const SegmentWords& s : region.segments) {
            program->segments.emplace_back(s.surface, s.slab,
                                           static_cast<std::uint32_t>(program->words.size()),
                                           static_cast<std::uint32_t>(s.words.size()));
            program->words.insert(program->words.end(), s.words.begin(), s.words.end());
        }
        body.regions.push_back(std::move(program));
    }
    return bus::pack(body);
}

/// Options of a frame.
struct Wishes {
    std::uint8_t opacity = full_opacity;  ///< Opacity of the second surface.
    bool read_depths = false;
    std::uint8_t sample = 0, samples = 1;
    unsigned views = 1;  ///< Each has its share of the assignment.
};

inline bus::Payload begin(std::uint32_t frame, const std::vector<std::uint16_t>& assignment,
                          Wishes wishes = {}) {
    schema::BeginFrameT body;
    body.draw = std::make_unique<schema::DrawFrameT>();
    body.draw->frame = frame;
    body.draw->width = static_cast<std::uint32_t>(128 * assignment.size() / wishes.views);
    body.draw->height = 128;
    for (unsigned i = 0; i < wishes.views; ++i) {
        auto view = std::make_unique<schema::ViewT>();
        view->voxel_to_eye = std::make_unique<schema::Matrix>();
        view->projection = std::make_unique<schema::Matrix>();
        body.draw->views.push_back(std::move(view));
    }
    body.draw->ambient = 1;
    body.draw->specular_power = 1;
    body.draw->background = std::make_unique<schema::Rgb>(10, 20, 30);
    // No lights and full ambient light: a pixel shows its surface's color.
    constexpr auto all = SlabChoice::all;
    body.draw->surfaces = {{0, 1, schema::Rgb(200, 100, 50), false, all, full_opacity, 0, 0},
                           {1, 1, schema::Rgb(1, 2, 3), false, all, wishes.opacity, 0, 0}};
    body.draw->read_depths = wishes.read_depths;
    body.draw->sample = wishes.sample;
    body.draw->samples = wishes.samples;
    body.assignment = assignment;
    return bus::pack(body);
}

inline constexpr std::uint32_t background = 10 | 20 << 8 | 30 << 16;
inline constexpr std::uint32_t colors[] = {200 | 100 << 8 | 50 << 16, 1 | 2 << 8 | 3 << 16};

/// A sheet of surface `surface` over the whole region.
inline WordList sheet(std::uint32_t surface, std::uint32_t depth) {
    test::TrianglePlanes t;
    put_edges({-3000, -3000}, {9000, -3000}, {-3000, 9000}, t);
    t.z[2] = static_cast<std::int32_t>(depth << 8);
    t.normals[2][2] = 500 << 16;
    t.surface = surface + 1;
    WordList words;
    append(t, words);
    return words;
}

/// One Renderer among `renderers`, with `gps` GPs.
struct RendererBench {
    RendererBench(int gps, int renderers, int index, int frame_buffers = 1)
        : id(static_cast<bus::NodeId>(first_renderer + index)) {
        schema::TopologyT topology;
        const auto add = [&](int node_id, schema::Role role, int i) {
            auto info = std::make_unique<schema::NodeInfoT>();
            info->id = static_cast<bus::NodeId>(node_id);
            info->role = role;
            info->index = static_cast<std::uint16_t>(i);
            topology.nodes.push_back(std::move(info));
        };
        add(bus::host_id, schema::Role::host, 0);
        for (int i = 0; i < gps; ++i) {
            add(first_gp + i, schema::Role::gp, i);
        }
        for (int i = 0; i < renderers; ++i) {
            add(first_renderer + i, schema::Role::renderer, i);
        }
        for (int i = 0; i < frame_buffers; ++i) {
            add(frame_buffer + i, schema::Role::frame_buffer, i);
        }
        take(bus::host_id, bus::pack(topology));
    }

    void take(int source, const bus::Payload& payload) {
        schema::Header header;
        header.mutate_magic(bus::header_magic);
        header.mutate_version(bus::protocol_version);
        header.mutate_kind(static_cast<std::uint16_t>(payload.kind()));
        header.mutate_source(static_cast<bus::NodeId>(source));
        header.mutate_destination(id);
        header.mutate_sequence(sequence++);
        header.mutate_body_bytes(payload.bytes().size());
        // A message body begins at a multiple of 8 bytes, but a payload may begin anywhere.
        const std::size_t size = payload.bytes().size();
        const auto copy = std::make_shared<std::vector<std::uint64_t>>(size / 8 + 1);
        std::memcpy(copy->data(), payload.bytes().data(), size);
        const auto* bytes = reinterpret_cast<const std::uint8_t*>(copy->data());
        node.receive({header, {bytes, size}, copy}, out);
    }
    void from_gp(int gp, const bus::Payload& payload) { take(first_gp + gp, payload); }

    /// Returns the text of the NodeFault that a message causes.
    std::string refused(int source, const bus::Payload& payload) {
        try {
            take(source, payload);
        } catch (const bus::NodeFault& fault) {
            return fault.what();
        }
        return "taken";
    }

    void work() {
        while (node.work(out)) {
        }
    }

    /// The RegionPixels that a frame buffer gets.
    std::vector<const schema::RegionPixels*> frames(int to = 0) const {
        std::vector<const schema::RegionPixels*> found;
        for (const RendererOutbox::Sent& s : out.sent) {
            if (s.payload.kind() == Body::RegionPixels) {
                CHECK(s.to >= frame_buffer);
                if (s.to == frame_buffer + to) {
                    found.push_back(
                        schema::GetMessage(s.payload.bytes().data())->body_as_RegionPixels());
                }
            }
        }
        return found;
    }
    std::vector<const schema::Fault*> fault_messages() const {
        std::vector<const schema::Fault*> found;
        for (const RendererOutbox::Sent& s : out.sent) {
            if (s.payload.kind() == Body::Fault) {
                CHECK(s.to == bus::host_id);
                found.push_back(schema::GetMessage(s.payload.bytes().data())->body_as_Fault());
                CHECK(found.back()->node() == id);
                CHECK(found.back()->frame().has_value());
                CHECK(found.back()->request() != 0);
            }
        }
        return found;
    }
    std::vector<std::string> faults() const {
        std::vector<std::string> found;
        for (const schema::Fault* fault : fault_messages()) {
            found.push_back(std::string(schema::EnumNameFaultCode(fault->code())) + ": " +
                            fault->reason()->str());
        }
        return found;
    }

    bus::NodeId id;
    std::uint64_t sequence = 0;
    RendererOutbox out;
    renderer::RendererNode node;
};

inline bool is_all(const schema::RegionPixels& pixels, std::size_t tile_number,
                   std::uint32_t color) {
    const auto* words = pixels.pixels()->data() + tile_number * tile;
    return std::all_of(words, words + tile, [=](std::uint32_t w) { return w == color; });
}

}  // namespace pxpl5::test
