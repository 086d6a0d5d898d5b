#include "host/session.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <span>

#include "host/digest.hpp"
#include "host/error.hpp"
#include "host/frame_request.hpp"
#include "host/nearest.hpp"
#include "host/phantom/phantom.hpp"

namespace pxpl5::host {

namespace {

namespace schema = bus::schema;

/// GPs prepare one frame while Renderers draw the other.
constexpr std::size_t frames_in_flight = 2;

std::int64_t now_ns() {
    return std::chrono::duration_cast<std::chrono::nanoseconds>(
               std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

double ms_since(std::int64_t start_ns) {
    return static_cast<double>(now_ns() - start_ns) * 1e-6;
}

/// Sums in slab order, so that rounding does not depend on which GP held which slab.
SurfaceReport sum_slabs(std::vector<schema::SlabCounts>& slabs) {
    std::sort(slabs.begin(), slabs.end(),
              [](const auto& p, const auto& q) { return p.slab() < q.slab(); });
    SurfaceReport report;
    for (const schema::SlabCounts& slab : slabs) {
        report.triangles += slab.triangles();
        report.vertices += slab.vertices();
        report.cells_active += slab.cells_active();
        report.cells_ambiguous += slab.cells_ambiguous();
        report.rows_skipped += slab.rows_skipped();
        report.area_mm2 += slab.area_mm2();
        report.volume_mm3 += slab.volume_mm3();
    }
    return report;
}

std::uint64_t digest_of(const schema::SlabMesh& mesh) {
    Digest digest;
    const auto add = [&digest](const auto& vector) {
        digest.add({reinterpret_cast<const std::byte*>(vector.Data()),
                    vector.size() * sizeof(*vector.data())});
    };
    add(*mesh.vertices());
    add(*mesh.keys());
    add(*mesh.indices());
    return digest.value();
}

}  // namespace

Session::Session(MachinePort& machine) : machine_(machine) {}

const Volume& Session::volume() const {
    if (!volume_) {
        throw RequestError(ExitCode::usage, "no volume is loaded; load one first: load VOLUME");
    }
    return *volume_;
}

void Session::wait(const std::string& what, const std::function<bool()>& done) {
    machine_.pump([this](const bus::Message& message) { on_message(message); },
                  [&] { return fault_.has_value() || done(); });
    if (fault_) {
        const std::string text = what + ": " + *fault_;
        fault_.reset();
        pending_.clear();
        finished_.clear();
        throw RequestError(ExitCode::failed, text);
    }
}

void Session::on_message(const bus::Message& message) {
    if (const auto* fault = message.as<schema::Fault>()) {
        on_fault(*fault);
    } else if (const auto* frame = message.as<schema::FrameDone>()) {
        on_frame_done(*frame);
    } else if (const auto* built = message.as<schema::SurfaceBuilt>()) {
        on_surface_built(*built);
    } else if (const auto* ready = message.as<schema::VolumeReady>()) {
        if (ready->volume() == volume_id_) {
            ++volume_ready_;
            memory_bytes_ += static_cast<std::int64_t>(ready->memory_bytes());
        }
    } else if (const auto* part = message.as<schema::MeshPart>()) {
        for (const auto* mesh : *part->slabs()) {
            slab_digests_[mesh->slab()] = digest_of(*mesh);
        }
        ++mesh_parts_;
    } else if (const auto* header = message.as<schema::VolumeHeader>()) {
        receiver_.emplace().begin(*header);
    } else if (const auto* slices = message.as<schema::Slices>(); slices != nullptr && receiver_) {
        receiver_->add(*slices);
    } else if (message.kind() == bus::Body::VolumeEnd && receiver_) {
        received_ = receiver_->finish();
    } else if (const auto* outcome = message.as<schema::IoDone>()) {
        io_done_ = true;
        if (!outcome->ok()) {
            throw RequestError(
                outcome->bad_data() ? ExitCode::bad_data : ExitCode::failed,
                outcome->error() ? outcome->error()->str() : "input or output failed");
        }
    }
}

void Session::on_fault(const schema::Fault& fault) {
    if (!fault_) {  // The first cause is the one to tell.
        fault_ = fault.reason()->str();
    }
}

void Session::with_io(const std::string& what, bus::Payload request,
                      const std::function<bool()>& done) {
    struct Release {
        MachinePort& machine;
        ~Release() { machine.release_io(); }
    };
    const bus::NodeId io = machine_.start_io();
    const Release release{machine_};
    io_done_ = false;
    received_.reset();
    receiver_.reset();
    machine_.send(io, std::move(request));
    wait(what, done);
}

Volume Session::read(const std::string& source) {
    if (is_phantom(source)) {
        try {
            return make_phantom(source);
        } catch (const std::invalid_argument& error) {
            throw RequestError(ExitCode::usage, error.what());
        }
    }
    schema::ImportVolumeT request;
    request.path = source;
    with_io(source, bus::pack(request), [this] { return received_.has_value(); });
    return std::move(*received_);
}

LoadReport Session::load(const std::string& source) {
    LoadReport report{source};
    std::int64_t start_ns = now_ns();
    Volume volume = read(source);
    report.read_ms = ms_since(start_ns);

    start_ns = now_ns();
    scene.surfaces.clear();
    reports_.clear();
    region_costs_.clear();
    volume_ = std::move(volume);
    ++volume_id_;
    volume_ready_ = 0;
    memory_bytes_ = 0;
    const std::vector<bus::NodeId>& gps = machine_.gp_ids();
    const bus::Payload header = volume_header(*volume_, volume_id_);
    for (std::size_t i = 0; i < gps.size(); ++i) {
        const std::vector<int> slices =
            slices_for_gp(volume_->nz, static_cast<int>(i), static_cast<int>(gps.size()));
        machine_.send(gps[i], header);
        for_each_slice_batch(*volume_, volume_id_, slices,
                             [&](bus::Payload batch) { machine_.send(gps[i], std::move(batch)); });
        machine_.send(gps[i], bus::pack(schema::VolumeEndT{{}, volume_id_}));
    }
    try {
        wait(source, [&] { return volume_ready_ == gps.size(); });
    } catch (const RequestError&) {
        volume_.reset();  // A GP could not hold its share: nothing is loaded.
        throw;
    }
    report.distribute_ms = ms_since(start_ns);
    report.memory_bytes = memory_bytes_;
    return report;
}

Surface& Session::find_surface(const std::string& name) {
    std::vector<std::string_view> names;
    for (Surface& surface : scene.surfaces) {
        if (surface.name == name) {
            return surface;
        }
        names.push_back(surface.name);
    }
    throw RequestError(ExitCode::usage, fmt::format("there is no surface '{}'{}", name,
                                                    names.empty() ? "; there is none yet"
                                                                  : did_you_mean(name, names)));
}

std::optional<Surface> Session::surface(const std::string& name) const {
    for (const Surface& known : scene.surfaces) {
        if (known.name == name) {
            return known;
        }
    }
    return std::nullopt;
}

void Session::set_colour(const std::string& name, Colour colour) {
    find_surface(name).colour = colour;
}

SurfaceReport Session::set_surface(const std::string& name, double isovalue, CaseTable table,
                                   Colour colour) {
    volume();
    auto found = std::find_if(scene.surfaces.begin(), scene.surfaces.end(),
                              [&](const Surface& surface) { return surface.name == name; });
    if (found == scene.surfaces.end()) {
        if (scene.surfaces.size() == max_surfaces) {
            throw RequestError(ExitCode::usage, fmt::format("{} surfaces are the most; remove one "
                                                            "before adding '{}'",
                                                            max_surfaces, name));
        }
        scene.surfaces.push_back({name, next_surface_id_++});
        found = scene.surfaces.end() - 1;
    }
    found->isovalue = isovalue;
    found->table = table;
    found->colour = colour;
    ++found->revision;

    const std::int64_t start_ns = now_ns();
    building_ = &*found;
    surface_ready_ = 0;
    slab_counts_.clear();
    memory_bytes_ = 0;
    schema::SetSurfaceT request;
    request.surface = found->id;
    request.revision = found->revision;
    request.isovalue = isovalue;
    request.table = static_cast<schema::CaseTable>(table);
    const bus::Payload payload = bus::pack(request);
    for (const bus::NodeId gp : machine_.gp_ids()) {
        machine_.send(gp, payload);
    }
    try {
        wait("surface " + name, [&] { return surface_ready_ == machine_.gp_ids().size(); });
    } catch (const RequestError&) {
        remove_surface(name);
        throw;
    }
    SurfaceReport report = sum_slabs(slab_counts_);
    report.elapsed_ms = ms_since(start_ns);
    report.memory_bytes = memory_bytes_;
    reports_.insert_or_assign(name, report);
    return report;
}

void Session::on_surface_built(const schema::SurfaceBuilt& built) {
    if (building_ == nullptr || built.surface() != building_->id ||
        built.revision() != building_->revision) {
        return;  // An answer to an older wish.
    }
    for (const schema::SlabCounts* slab : *built.slabs()) {
        slab_counts_.push_back(*slab);
    }
    memory_bytes_ += static_cast<std::int64_t>(built.memory_bytes());
    ++surface_ready_;
}

void Session::remove_surface(const std::string& name) {
    const Surface& surface = find_surface(name);
    schema::RemoveSurfaceT request;
    request.surface = surface.id;
    const bus::Payload payload = bus::pack(request);
    for (const bus::NodeId gp : machine_.gp_ids()) {
        machine_.send(gp, payload);
    }
    building_ = nullptr;
    reports_.erase(name);
    std::erase_if(scene.surfaces, [&](const Surface& other) { return other.name == name; });
}

const SurfaceReport& Session::report_of(const std::string& name) const {
    const auto found = reports_.find(name);
    if (found == reports_.end()) {
        throw RequestError(ExitCode::usage, fmt::format("there is no surface '{}'", name));
    }
    return found->second;
}

std::uint32_t Session::submit_frame() {
    const std::uint32_t frame = next_frame_++;
    pending_.push_back({frame, now_ns()});
    machine_.send(machine_.gp_ids().front(), frame_request(scene, volume(), frame, region_costs_));
    return frame;
}

void Session::on_frame_done(const schema::FrameDone& done) {
    if (pending_.empty() || done.frame() != pending_.front().frame || done.pixels() == nullptr) {
        return;  // A frame that was given up after a fault.
    }
    last_frame_ = {done.frame(), static_cast<std::int64_t>(done.instructions()), 0,
                   ms_since(pending_.front().started_ns)};
    region_costs_.assign(done.region_cycles()->begin(), done.region_cycles()->end());
    for (const std::uint64_t cycles : region_costs_) {
        last_frame_.renderer_cycles += static_cast<std::int64_t>(cycles);
    }
    Picture picture{static_cast<int>(done.width()),
                    static_cast<int>(done.height() * done.views()),
                    {done.pixels()->begin(), done.pixels()->end()}};
    finished_.push_back(std::move(picture));
    pending_.pop_front();
}

Picture Session::take_frame() {
    wait("frame", [this] { return !finished_.empty(); });
    Picture picture = std::move(finished_.front());
    finished_.pop_front();
    return picture;
}

Picture Session::draw() {
    submit_frame();
    return take_frame();
}

OrbitReport Session::orbit(int frames, const std::function<void(int, const Picture&)>& take) {
    struct Restore {
        Camera& camera;
        const Camera before = camera;
        ~Restore() { camera = before; }
    };
    const Restore restore{scene.camera};
    const std::int64_t start_ns = now_ns();
    for (int submitted = 0, taken = 0; taken < frames; ++taken) {
        for (; submitted < frames && pending_.size() + finished_.size() < frames_in_flight;
             ++submitted) {
            scene.camera.angles.azimuth_deg =
                restore.before.angles.azimuth_deg + 360.0 * submitted / frames;
            submit_frame();
        }
        take(taken, take_frame());
    }
    return {frames, ms_since(start_ns)};
}

void Session::export_picture(const Picture& picture, const std::string& path,
                             const std::string& description) {
    flatbuffers::FlatBufferBuilder builder(picture.rgba.size() * 4 + 1024);
    const auto rgba = builder.CreateVector(
        reinterpret_cast<const std::uint8_t*>(picture.rgba.data()), picture.rgba.size() * 4);
    const auto path_text = builder.CreateString(path);
    const auto description_text = builder.CreateString(description);
    with_io(path,
            bus::finish(builder,
                        schema::CreateExportPicture(
                            builder, path_text, static_cast<std::uint32_t>(picture.width),
                            static_cast<std::uint32_t>(picture.height), rgba, description_text)),
            [this] { return io_done_; });
}

std::uint64_t Session::mesh_digest(const std::string& name) {
    schema::FetchMeshT request;
    request.surface = find_surface(name).id;
    const bus::Payload payload = bus::pack(request);
    slab_digests_.clear();
    mesh_parts_ = 0;
    for (const bus::NodeId gp : machine_.gp_ids()) {
        machine_.send(gp, payload);
    }
    wait("mesh of " + name, [&] { return mesh_parts_ == machine_.gp_ids().size(); });
    Digest digest;
    for (const auto& [slab, value] : slab_digests_) {
        digest.add(std::as_bytes(std::span(&value, 1)));
    }
    return digest.value();
}

}  // namespace pxpl5::host
