#include "tests/bench/parts.hpp"

#include <cstring>
#include <stdexcept>

#include "host/scene/camera.hpp"
#include "host/session/transfer/frame_request.hpp"
#include "host/session/transfer/volume_transfer.hpp"

namespace pxpl5::bench {

namespace {

namespace schema = bus::schema;

constexpr std::uint64_t gp_memory_bytes = std::uint64_t{4} << 30;
constexpr std::uint32_t volume_id = 1;
constexpr double step_deg = 3.6;

bus::Payload topology() {
    schema::TopologyT t;
    const auto add = [&t](bus::NodeId id, schema::Role role) {
        auto node = std::make_unique<schema::NodeInfoT>();
        node->id = id;
        node->role = role;
        t.nodes.push_back(std::move(node));
    };
    add(bus::host_id, schema::Role::host);
    add(gp_id, schema::Role::gp);
    add(renderer_id, schema::Role::renderer);
    add(frame_buffer_id, schema::Role::frame_buffer);
    t.gp_memory_bytes = gp_memory_bytes;
    t.ring_channels = 8;
    return bus::pack(t);
}

}  // namespace

const bus::Payload& Wire::first(bus::Body kind) const {
    for (const bus::Payload& payload : sent) {
        if (payload.kind() == kind) {
            return payload;
        }
    }
    throw std::logic_error("no " + bus::kind_name(kind));
}

Held::Held(const bus::Payload& payload)
    : kind_(payload.kind()),
      size_bytes_(payload.bytes().size()),
      words_(std::make_shared<std::vector<std::uint64_t>>(size_bytes_ / 8 + 1)) {
    std::memcpy(words_->data(), payload.bytes().data(), size_bytes_);
}

void Held::set_frame(std::uint32_t frame) {
    schema::Message* message = schema::GetMutableMessage(words_->data());
    void* body = message->mutable_body();
    if (kind_ == bus::Body::BeginFrame) {
        static_cast<schema::BeginFrame*>(body)->mutable_draw()->mutate_frame(frame);
    } else if (kind_ == bus::Body::RegionPrograms) {
        static_cast<schema::RegionPrograms*>(body)->mutate_frame(frame);
    } else if (kind_ == bus::Body::RegionPixels) {
        static_cast<schema::RegionPixels*>(body)->mutate_frame(frame);
    } else {
        throw std::logic_error(bus::kind_name(kind_) + " has no frame");
    }
}

bus::Message Held::message(bus::NodeId to) const {
    bus::NodeId source = gp_id;
    if (kind_ == bus::Body::RegionPixels) {
        source = renderer_id;
    } else if (kind_ != bus::Body::BeginFrame && kind_ != bus::Body::RegionPrograms) {
        source = bus::host_id;
    }
    const schema::Header header(bus::header_magic, bus::protocol_version,
                                static_cast<std::uint16_t>(kind_), source, to, 0, 0, 0, size_bytes_,
                                0, 0, 0);
    return {header, {reinterpret_cast<const std::uint8_t*>(words_->data()), size_bytes_}, words_};
}

Parts::Parts(std::string_view phantom, host::Size size) : volume_(host::make_phantom(phantom)) {
    scene_.size = size;
    introduce();
    load();
    const host::PhantomSurface shown = host::suggested_surfaces(volume_.name).front();
    host::Surface surface;
    surface.name = shown.name;
    surface.isovalue = shown.isovalue;
    scene_.surfaces.push_back(surface);
    extract();
}

void Parts::introduce() {
    const Held held(topology());
    gp.receive(held.message(gp_id), gp_wire);
    renderer.receive(held.message(renderer_id), renderer_wire);
    frame_buffer.receive(held.message(frame_buffer_id), frame_buffer_wire);
}

void Parts::load() {
    gp.receive(Held(host::volume_header(volume_, volume_id)).message(gp_id), gp_wire);
    const std::size_t slice_bytes = volume_.values.size() / static_cast<std::size_t>(volume_.nz);
    for (std::size_t z = 0; z < static_cast<std::size_t>(volume_.nz); ++z) {
        schema::SlicesT slices;
        slices.volume = volume_id;
        slices.first_slice = static_cast<std::uint32_t>(z);
        slices.slice_count = 1;
        slices.values.resize(slice_bytes);
        std::memcpy(slices.values.data(), volume_.values.data() + z * slice_bytes, slice_bytes);
        gp.receive(Held(bus::pack(slices)).message(gp_id), gp_wire);
    }
    schema::VolumeEndT end;
    end.volume = volume_id;
    gp.receive(Held(bus::pack(end)).message(gp_id), gp_wire);
    work(gp, gp_wire);
}

std::uint32_t Parts::extract() {
    host::Surface& surface = scene_.surfaces.front();
    schema::SetSurfaceT set;
    set.surface = surface.id;
    set.revision = ++surface.revision;
    set.isovalue = surface.isovalue;
    gp_wire.sent.clear();
    gp.receive(Held(bus::pack(set)).message(gp_id), gp_wire);
    work(gp, gp_wire);
    const bus::Payload& built = gp_wire.first(bus::Body::SurfaceBuilt);
    std::uint32_t triangles = 0;
    for (const auto* slab :
         *schema::GetMessage(built.bytes().data())->body_as_SurfaceBuilt()->slabs()) {
        triangles += slab->triangles();
    }
    return triangles;
}

void Parts::draw(std::uint32_t frame) {
    scene_.camera.angles.azimuth_deg = step_deg * frame;
    const host::Subject subject =
        host::subject_of(volume_.nx, volume_.ny, volume_.nz, volume_.voxel_to_patient);
    const host::Stage stage{scene_.surfaces, subject, volume_.voxel_to_patient,
                            false,           0,       host::cameras_of(scene_, subject)};
    gp_wire.sent.clear();
    gp.receive(Held(host::frame_request(scene_, stage, frame, {})).message(gp_id), gp_wire);
    work(gp, gp_wire);
}

}  // namespace pxpl5::bench
