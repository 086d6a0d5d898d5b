// Loads a PPHIGS archive: the GPs take its content as a scene.
#include <fmt/core.h>

#include "host/base/error.hpp"
#include "host/base/stopwatch.hpp"
#include "host/session/transfer/scene_transfer.hpp"
#include "host/session/volumes.hpp"

namespace pxpl5::host {

namespace schema = bus::schema;

/// The ArchiveContent of a file. Throws RequestError.
bus::Message Volumes::read_content(const std::string& source) {
    schema::ReadArchiveT request;
    request.path = source;
    IoOutcome read = io_.read(source, bus::pack(request), ExitCode::bad_data);
    if (!read.content) {
        throw RequestError(
            ExitCode::bad_data,
            fmt::format("{}: the io process answered without the content of the archive", source));
    }
    return std::move(*read.content);
}

ArchiveFacts Volumes::read_archive(const std::string& source) {
    return facts_of(source, *read_content(source).as<schema::ArchiveContent>());
}

LoadReport Volumes::load_archive(const std::string& source) {
    const std::int64_t start_ns = now_ns();
    const bus::Message message = [&] {
        const Cancellable cancellable(conversation_.machine());
        return read_content(source);
    }();
    const double read_ms = ms_since(start_ns);
    if (settings_.will_write) {
        conversation_.machine().prepare_io();
    }
    LoadReport report = distribute_archive(source, message);
    report.read_ms = read_ms;
    return report;
}

LoadReport Volumes::distribute_archive(const std::string& source, const bus::Message& message) {
    const std::int64_t start_ns = now_ns();
    const auto& content = *message.as<schema::ArchiveContent>();
    LoadReport report{source};
    replace_content();
    HeldArchive held{facts_of(source, content), {}};
    std::vector<std::uint16_t> ids;
    for (const ArchiveFacts::Look& material : held.facts.materials) {
        Surface surface;
        surface.id = new_surface_id();
        surface.revision = 1;
        surface.color = material.color;
        surface.cull_back = material.cull_back;
        held.surfaces.push_back(surface);
        ids.push_back(surface.id);
    }
    MachinePort& machine = conversation_.machine();
    const std::vector<bus::NodeId>& gps = conversation_.gps();
    for (const bus::NodeId gp : gps) {
        machine.send(gp, scene_begin(id_, ids));
    }
    for (const schema::ScenePart* part : *content.parts()) {
        machine.send(gps[part->slab() % gps.size()], scene_part(*part, id_, ids[part->surface()]));
    }
    for (const bus::NodeId gp : gps) {
        machine.send(gp, scene_end(id_));
    }
    conversation_.wait_for_answers(source);  // Throws if a GP cannot hold its share.
    if (held.facts.specular_power != 0) {  // All materials get one gloss, because a frame has one.
        scene_.material.specular = held.facts.specular;
        scene_.material.specular_power = held.facts.specular_power;
    }
    archive_ = std::move(held);
    report.distribute_ms = ms_since(start_ns);
    report.memory_bytes = memory_bytes_;
    return report;
}

}  // namespace pxpl5::host
