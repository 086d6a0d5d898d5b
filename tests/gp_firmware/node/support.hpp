// A GP node in a test: real messages in, real messages out, on a small sphere.
#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/gtc/matrix_transform.hpp>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "gp_firmware/node/node.hpp"
#include "gp_firmware/volume/share.hpp"

namespace pxpl5::test {

namespace schema = bus::schema;
using bus::NodeId;

constexpr int n = 20;
constexpr NodeId first_gp = 1, first_renderer = 50, frame_buffer = 90;
constexpr std::uint64_t plenty_bytes = 1 << 24;

struct Sent {
    NodeId to;
    bus::Payload payload;

    template <typename T>
    const T* as() const {
        return schema::GetMessage(payload.bytes().data())->body_as<T>();
    }
};

struct Mailbox final : bus::Outbox {
    void send(NodeId to, bus::Payload payload) override { sent.push_back({to, payload}); }
    using bus::Outbox::send;

    template <typename T>
    std::vector<const T*> of() const {
        std::vector<const T*> found;
        for (const Sent& s : sent) {
            if (const T* body = s.as<T>()) {
                found.push_back(body);
            }
        }
        return found;
    }
    std::vector<Sent> sent;
};

/// A message as the wire would hand it over: verified.
inline bus::Message message(const bus::Payload& payload, NodeId from, NodeId to) {
    const auto bytes = payload.bytes();
    const auto words = std::make_shared<std::vector<std::uint64_t>>((bytes.size() + 7) / 8);
    std::memcpy(words->data(), bytes.data(), bytes.size());
    const schema::Header header(bus::header_magic, bus::protocol_version,
                                static_cast<std::uint16_t>(payload.kind()), from, to, 0, 0, 0,
                                bytes.size(), 0, 0, 0);
    return {header, {reinterpret_cast<const std::uint8_t*>(words->data()), bytes.size()}, words};
}

inline schema::Matrix to_wire(const glm::dmat4& m) {
    std::array<double, 16> values{};
    std::memcpy(values.data(), &m, sizeof values);
    return schema::Matrix(flatbuffers::make_span(values));
}

struct MachineSize {
    int gps = 1, renderers = 1;
    std::uint64_t memory_bytes = plenty_bytes;
    Recording recording = Recording::off;
    int slabs_per_set = 1;
};

inline bus::Payload topology(MachineSize size) {
    schema::TopologyT t;
    const auto add = [&](NodeId id, schema::Role role, int index) {
        auto node = std::make_unique<schema::NodeInfoT>();
        node->id = id;
        node->role = role;
        node->index = static_cast<std::uint16_t>(index);
        t.nodes.push_back(std::move(node));
    };
    add(bus::host_id, schema::Role::host, 0);
    for (int i = size.gps; i-- > 0;) {  // Not in the order of their indices.
        add(static_cast<NodeId>(first_gp + i), schema::Role::gp, i);
    }
    for (int i = 0; i < size.renderers; ++i) {
        add(static_cast<NodeId>(first_renderer + i), schema::Role::renderer, i);
    }
    add(frame_buffer, schema::Role::frame_buffer, 0);
    t.gp_memory_bytes = size.memory_bytes;
    t.ring_channels = 8;
    t.recording = size.recording;
    return bus::pack(t);
}

/// One GP and what it has sent.
struct LoneGp {
    LoneGp(MachineSize size, int index)
        : id(static_cast<NodeId>(first_gp + index)), share{index, size.gps} {
        receive(topology(size));
    }
    void receive(const bus::Payload& payload, NodeId from = bus::host_id) {
        node.receive(message(payload, from, id), box);
    }
    /// Receives, and returns the fault that this throws.
    std::string fault_of(const bus::Payload& payload) {
        try {
            receive(payload);
        } catch (const bus::NodeFault& fault) {
            code = fault.code;
            cause = fault.cause;
            return fault.what();
        }
        return {};
    }
    /// Works until nothing is left. Returns the pieces it took.
    int work() {
        int pieces = 1;
        while (node.work(box)) {
            ++pieces;
        }
        return pieces;
    }
    std::string fault_of_work() {
        try {
            work();
        } catch (const bus::NodeFault& fault) {
            code = fault.code;
            cause = fault.cause;
            return fault.what();
        }
        return {};
    }

    gp::GpNode node;
    Mailbox box;
    NodeId id;
    gp::Share share;
    schema::FaultCode code{};
    bus::FaultCause cause;
};

inline gp::VolumeShape shape() {
    return {n, n, n, Scalar::uint8, glm::dmat4(1.0), 0, 255};
}

inline bus::Payload header(std::uint32_t volume = 1, int slabs_per_set = 1) {
    schema::VolumeHeaderT h;
    h.volume = volume;
    h.name = "sphere";
    h.nx = h.ny = h.nz = n;
    h.type = Scalar::uint8;
    h.voxel_to_patient = std::make_unique<schema::Matrix>(to_wire(glm::dmat4(1.0)));
    h.maximum = 255;
    h.slabs_per_set = static_cast<std::uint16_t>(slabs_per_set);
    return bus::pack(h);
}

/// Distance from the middle decides: 100 at radius 7.
inline bus::Payload slices(int first, int count, std::uint32_t volume = 1) {
    schema::SlicesT s;
    s.volume = volume;
    s.first_slice = static_cast<std::uint32_t>(first);
    s.slice_count = static_cast<std::uint32_t>(count);
    for (int z = first; z < first + count; ++z) {
        for (int y = 0; y < n; ++y) {
            for (int x = 0; x < n; ++x) {
                const double r = std::hypot(x - 9.5, y - 9.5, z - 9.5);
                s.values.push_back(static_cast<std::uint8_t>(
                    std::clamp(std::lround(100 + (7 - r) * 10), 0L, 255L)));
            }
        }
    }
    return bus::pack(s);
}

inline void load(LoneGp& gp, std::uint32_t volume = 1, int slabs_per_set = 1) {
    gp.receive(header(volume, slabs_per_set));
    gp::VolumeShape in_sets = shape();
    in_sets.slabs_per_set = slabs_per_set;
    for (const int z : gp::slices_needed(in_sets, gp.share)) {
        gp.receive(slices(z, 1, volume));
    }
    schema::VolumeEndT end;
    end.volume = volume;
    gp.receive(bus::pack(end));
    gp.work();
}

inline bus::Payload set_surface(std::uint16_t surface, std::uint32_t revision, double isovalue) {
    schema::SetSurfaceT s;
    s.surface = surface;
    s.revision = revision;
    s.isovalue = isovalue;
    return bus::pack(s);
}

inline schema::DrawFrameT draw_frame(std::uint32_t frame, std::uint32_t revision) {
    schema::DrawFrameT d;
    d.frame = frame;
    d.width = 300;
    d.height = 200;
    auto view = std::make_unique<schema::ViewT>();
    view->voxel_to_eye = std::make_unique<schema::Matrix>(
        to_wire(glm::translate(glm::dmat4(1.0), glm::dvec3(-9.5, -9.5, -50))));
    view->projection =
        std::make_unique<schema::Matrix>(to_wire(glm::perspective(0.5, 1.5, 10.0, 100.0)));
    d.views.push_back(std::move(view));
    d.specular_power = 10;
    d.background = std::make_unique<schema::Rgb>();
    d.surfaces.emplace_back(std::uint16_t{4}, revision, schema::Rgb(), false, SlabChoice::all,
                            full_opacity, std::uint8_t{0}, std::uint8_t{0});
    return d;
}

/// Runs a machine: all GPs load, extract surface 4 and draw `draw`; what each sent.
inline std::vector<std::unique_ptr<LoneGp>> run_machine(MachineSize size,
                                                        const schema::DrawFrameT& draw) {
    std::vector<std::unique_ptr<LoneGp>> gps;
    for (int i = 0; i < size.gps; ++i) {
        gps.push_back(std::make_unique<LoneGp>(size, i));
        load(*gps.back(), 1, size.slabs_per_set);
        gps.back()->receive(set_surface(4, 1, 100));
    }
    gps[0]->receive(bus::pack(draw));
    const std::vector<Sent> from_master = gps[0]->box.sent;
    for (const Sent& s : from_master) {
        for (auto& gp : gps) {
            if (s.to == gp->id) {
                gp->receive(s.payload, first_gp);
            }
        }
    }
    for (auto& gp : gps) {
        gp->work();
    }
    return gps;
}

/// Words per region and slab over all GPs and Renderers.
inline std::map<std::pair<int, std::uint32_t>, std::vector<std::uint32_t>> streams(
    const std::vector<std::unique_ptr<LoneGp>>& gps) {
    std::map<std::pair<int, std::uint32_t>, std::vector<std::uint32_t>> result;
    for (const auto& gp : gps) {
        for (const auto* programs : gp->box.of<schema::RegionPrograms>()) {
            for (const auto* region : *programs->regions()) {
                for (const auto* s : *region->segments()) {
                    CHECK(s->surface() == 0);
                    auto& words = result[{region->region(), s->slab()}];
                    CHECK(words.empty());  // A slab belongs to one GP.
                    const auto first = region->words()->begin() + s->first_word();
                    words.assign(first, first + s->word_count());
                }
            }
        }
    }
    return result;
}

}  // namespace pxpl5::test
