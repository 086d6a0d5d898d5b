#include "host/session/volumes.hpp"

#include <fmt/core.h>

#include <set>
#include <utility>

#include "host/base/error.hpp"
#include "host/base/stopwatch.hpp"
#include "host/session/transfer/scene_transfer.hpp"

namespace pxpl5::host {

namespace schema = bus::schema;

Volumes::Volumes(Conversation& conversation, IoRequests& io, Scene& scene,
                 const LoadSettings& settings, std::function<void()> on_replaced)
    : conversation_(conversation),
      scene_(scene),
      settings_(settings),
      on_replaced_(std::move(on_replaced)),
      io_(io),
      reader_(conversation, io, settings) {}

const Volume& Volumes::volume() const {
    if (archive_) {
        throw RequestError(ExitCode::usage,
                           fmt::format("{} is a scene of polygons, spheres and lines: it has no "
                                       "voxels and no isosurfaces; load a volume for them",
                                       archive_->facts.file));
    }
    if (!volume_) {
        throw RequestError(ExitCode::usage, "no volume is loaded; load one first: load VOLUME");
    }
    return *volume_;
}

Volume Volumes::read(const std::string& source, const ImportOptions& options) {
    if (is_archive(source)) {
        throw RequestError(ExitCode::usage, source + " is a scene, not a volume");
    }
    return reader_.read(source, options);
}

std::vector<Volume> Volumes::read_of_series(int frame, int count) {
    const Conversation::Cancelable cancelable(conversation_);
    ImportOptions options = options_;
    options.frame = static_cast<std::uint32_t>(frame);
    options.volumes = static_cast<std::uint32_t>(count);
    return reader_.read_several(volume().source, options);
}

/// A volume on its way to the GPs. It may still be read meanwhile.
struct Volumes::Loading {
    std::string source;
    std::optional<VolumeDistribution> distribution;  ///< None until the volume's shape is known.
    LoadProgress reported;
    bool is_told = true;  ///< Whether progress is reported.
};

LoadReport Volumes::load(const std::string& source, const ImportOptions& options) {
    if (source.empty()) {
        throw RequestError(ExitCode::usage, "load: the name of the volume is empty");
    }
    if (is_archive(source)) {
        return load_archive(source);
    }
    const Cancellable cancellable(conversation_.machine());
    Loading loading{source, {}, {}};
    try {
        return load_volume(loading, options);
    } catch (const MachineError&) {
        if (loading.distribution) {
            volume_.reset();  // The scene before the load does not fit it.
        }
        throw;
    } catch (const std::exception&) {
        if (loading.distribution) {
            discard_canceled();
        }
        throw;
    }
}

/// Discards a volume. A machine that dies meanwhile must not hide the error of the load: the next
/// request meets the death.
void Volumes::discard_canceled() {
    try {
        discard_volume();
    } catch (const MachineError& death) {
        if (death.is_interruption) {
            throw;
        }
        volume_.reset();
    }
}

LoadReport Volumes::load_volume(Loading& loading, const ImportOptions& options) {
    LoadReport report{loading.source};
    std::int64_t start_ns = now_ns();
    report_progress({LoadProgress::Phase::reading, 0, 0}, loading);
    Volume volume =
        reader_.read(loading.source, options, [this, &loading](Volume& coming, int slices_there) {
            distribute(coming, slices_there, loading);
        });
    report.read_ms = ms_since(start_ns);

    start_ns = now_ns();
    options_ = options;
    ++loads_;
    send(volume, loading);
    report.distribute_ms = ms_since(start_ns);
    report.memory_bytes = memory_bytes_;
    return report;
}

/// Sends the rest of a complete volume, and keeps it.
void Volumes::send(Volume& volume, Loading& loading) {
    distribute(volume, volume.nz, loading);
    volume_ = std::move(volume);
    scene_.frame = volume_->frame;
    conversation_.wait(loading.source, [this, &loading] {
        distribute(*volume_, volume_->nz, loading);
        return conversation_.is_answered();
    });
}

void Volumes::give_again() {
    if (archive_) {
        const HeldArchive held = *archive_;
        try {
            distribute_archive(held.facts.file, read_content(held.facts.file));
        } catch (const std::exception&) {
            archive_ = held;
            throw;
        }
        return;
    }
    if (!volume_) {
        scene_.surfaces.clear();
        on_replaced_();
        return;
    }
    Volume volume = std::move(*volume_);
    Loading loading{volume.source, {}, {}};
    try {
        send(volume, loading);
    } catch (const std::exception&) {
        if (!volume_) {
            volume_ = std::move(volume);
        }
        throw;
    }
}

Volume Volumes::exchange(Volume next) {
    Volume former = std::move(volume_.value());
    Loading loading{next.source, {}, {}, false};
    try {
        send(next, loading);
    } catch (const MachineError&) {
        scene_.frame = former.frame;
        volume_ = std::move(former);
        throw;
    } catch (const std::exception&) {
        discard_canceled();
        throw;
    }
    options_.frame = static_cast<std::uint32_t>(volume_->frame);
    return former;
}

void Volumes::drop() {
    replace_content();
    discard_volume();
}

std::uint16_t Volumes::new_surface_id() {
    std::uint16_t id = next_surface_id_++;
    while (id == plane_surface_id || std::ranges::count(scene_.surfaces, id, &Surface::id) != 0) {
        id = next_surface_id_++;
    }
    return id;
}

/// Drops the content of the GPs, and expects VolumeReady for the next content.
void Volumes::replace_content() {
    scene_.surfaces.clear();
    scene_.clips.clear();
    scene_.planes.clear();
    on_replaced_();
    scene_.frame = 1;
    archive_.reset();
    volume_.reset();
    ++id_;
    memory_bytes_ = 0;
    conversation_.expect([this](const bus::Message& message) {
        const auto* ready = message.as<schema::VolumeReady>();
        if (ready == nullptr || ready->volume() != id_) {
            return false;
        }
        memory_bytes_ += static_cast<std::int64_t>(ready->memory_bytes());
        return true;
    });
}

void Volumes::begin_distribution(Volume& volume, Loading& loading) {
    if (volume.nz < 2) {
        throw RequestError(
            ExitCode::bad_data,
            fmt::format("{}: {} x {} x {} voxels are a single slice, which has no surface: "
                        "load the folder or the file that also has the other slices. info "
                        "describes this one",
                        loading.source, volume.nx, volume.ny, volume.nz));
    }
    replace_content();  // Not earlier, because the new volume might have been unreadable.
    const int gp_count = static_cast<int>(conversation_.gps().size());
    const int of_topology = conversation_.machine().slabs_per_set();
    volume.slabs_per_set = settings_.slabs_per_set != 0 ? settings_.slabs_per_set
                           : of_topology != 0           ? of_topology
                                                        : slabs_per_set_for(volume, gp_count);
    const bus::Payload header = volume_header(volume, id_);
    for (const bus::NodeId gp : conversation_.gps()) {
        conversation_.machine().send(gp, header);
    }
    loading.distribution.emplace(volume, id_, gp_count);
}

/// Sends the slices that are there to the GPs that take more.
void Volumes::distribute(Volume& volume, int slices_there, Loading& loading) {
    if (!loading.distribution) {
        begin_distribution(volume, loading);
    }
    MachinePort& machine = conversation_.machine();
    const std::vector<bus::NodeId>& gps = conversation_.gps();
    VolumeDistribution& distribution = *loading.distribution;
    distribution.send_more(
        volume, slices_there,
        {[&](std::size_t gp) { return machine.takes_more(gps[gp]); },
         [&](std::size_t gp, const bus::Payload& payload) { machine.send(gps[gp], payload); },
         machine.body_allocator()});
    report_progress(slices_there < volume.nz
                        ? LoadProgress{LoadProgress::Phase::reading, slices_there, volume.nz}
                        : LoadProgress{LoadProgress::Phase::distributing, distribution.sent(),
                                       distribution.total()},
                    loading);
}

void Volumes::report_progress(const LoadProgress& now, Loading& loading) const {
    if (loading.is_told && settings_.progress && now != std::exchange(loading.reported, now)) {
        settings_.progress(now);
    }
}

/// Discards a volume that is not complete, on the GPs and in messages on their way.
void Volumes::discard_volume() {
    MachinePort& machine = conversation_.machine();
    machine.allow_cancel(false);  // The rest is short, and must not stop half way.
    volume_.reset();
    schema::DropVolumeT drop;
    drop.volume = id_;
    // An empty scene replaces the volume. A GP that reports the scene ready has sent all of its
    // messages about the volume before.
    ++id_;
    for (const bus::NodeId gp : conversation_.gps()) {
        machine.send(gp, bus::pack(drop));
        machine.send(gp, scene_begin(id_, {}));
        machine.send(gp, scene_end(id_));
    }
    std::set<bus::NodeId> ready;
    conversation_.discard_until(
        [&](const bus::Message& message) {
            const auto* reported = message.as<schema::VolumeReady>();
            if (reported != nullptr && reported->volume() == id_) {
                ready.insert(message.source());
            }
        },
        [&] { return ready.size() == conversation_.gps().size(); });
    drop.volume = id_;
    for (const bus::NodeId gp : conversation_.gps()) {
        machine.send(gp, bus::pack(drop));
    }
}

// Archives: the GPs take their content as a scene.

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
