#include "host/session.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <span>
#include <utility>

#include "host/digest.hpp"
#include "host/error.hpp"
#include "host/nearest.hpp"
#include "host/scene_transfer.hpp"
#include "host/stopwatch.hpp"

namespace pxpl5::host {

namespace {

namespace schema = bus::schema;

/// GPs prepare one frame while Renderers draw the other.
constexpr std::size_t frames_in_flight = 2;

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
    if (archive_) {
        throw RequestError(ExitCode::usage,
                           fmt::format("{} is a scene of polygons, spheres and lines: it has no "
                                       "voxels and no isosurfaces; load a volume for them",
                                       archive_->content.file));
    }
    if (!volume_) {
        throw RequestError(ExitCode::usage, "no volume is loaded; load one first: load VOLUME");
    }
    return *volume_;
}

void Session::wait(const std::string& what, const std::function<bool()>& done) {
    machine_.pump([this](const bus::Message& message) { on_message(message); }, done);
    if (fault_) {
        const std::string text =
            what + ": " + *std::exchange(fault_, std::nullopt) + traces_of_fault();
        throw RequestError(ExitCode::failed, text);
    }
}

void Session::wait_for_gps(const std::string& what) {
    wait(what, [this] {
        return std::all_of(machine_.gp_ids().begin(), machine_.gp_ids().end(),
                           [this](bus::NodeId gp) { return answered_.count(gp) != 0; });
    });
}

void Session::on_message(const bus::Message& message) {
    on_answer(message);
    if (const auto* fault = message.as<schema::Fault>()) {
        on_fault(*fault);
    } else if (const auto* frame = message.as<schema::FrameDone>()) {
        on_frame_done(*frame);
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

/// A GP's word on the volume, surface or mesh that was asked for.
void Session::on_answer(const bus::Message& message) {
    bool is_answer = message.kind() == bus::Body::Fault;
    if (const auto* ready = message.as<schema::VolumeReady>()) {
        is_answer = ready->volume() == volume_id_;
        memory_bytes_ += static_cast<std::int64_t>(ready->memory_bytes());
    } else if (const auto* built = message.as<schema::SurfaceBuilt>()) {
        is_answer = building_ != nullptr && built->surface() == building_->id &&
                    built->revision() == building_->revision;
        if (is_answer) {
            on_surface_built(*built);
        }
    } else if (const auto* part = message.as<schema::MeshPart>()) {
        is_answer = fetching_ != nullptr && part->surface() == fetching_->id &&
                    part->revision() == fetching_->revision;
        for (const auto* mesh : *part->slabs()) {
            slab_digests_[mesh->slab()] = digest_of(*mesh);
        }
    }
    if (is_answer) {
        answered_.insert(message.source());
    }
}

void Session::on_fault(const schema::Fault& fault) {
    if (!fault_) {  // The first cause is the one to tell.
        fault_ = fault.reason()->str();
        fault_is_ours_ = fault.code() != schema::FaultCode::bad_input &&
                         fault.code() != schema::FaultCode::out_of_memory;
    }
}

Surface& Session::find_surface(const std::string& name) {
    if (archive_) {
        volume();  // Throws: a scene has no surfaces that could be named.
    }
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
    begin_request();
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
        wait_for_gps("surface " + name);
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
    for (const schema::SlabCounts* slab : *built.slabs()) {
        slab_counts_.push_back(*slab);
    }
    memory_bytes_ += static_cast<std::int64_t>(built.memory_bytes());
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

Stage Session::stage() const {
    if (archive_) {
        return {archive_->surfaces, phigs::scene_subject(), glm::dmat4(1.0)};
    }
    const Volume& held = volume();
    return {scene.surfaces, subject_of(held.nx, held.ny, held.nz, held.voxel_to_patient),
            held.voxel_to_patient};
}

void Session::submit_frame() {
    const bus::Payload request = frame_request(scene, stage(), next_frame_, region_costs_);
    pending_.push_back({next_frame_++, now_ns()});
    machine_.send(machine_.gp_ids().front(), request);
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

void Session::give_up_frames() {
    pending_.clear();
    finished_.clear();
}

Picture Session::take_frame() {
    try {
        wait("frame", [this] { return !finished_.empty() || fault_.has_value(); });
    } catch (...) {
        give_up_frames();  // What still comes of them is not what is asked for next.
        throw;
    }
    Picture picture = std::move(finished_.front());
    finished_.pop_front();
    return picture;
}

Picture Session::draw() {
    submit_frame();
    return take_frame();
}

OrbitReport Session::orbit(int frames, const std::function<void(int, const Picture&)>& take) {
    // Whatever `take` throws, the camera is where it was and no frame of the orbit is left over.
    struct Restore {
        Session& session;
        const Camera before = session.scene.camera;
        ~Restore() {
            session.scene.camera = before;
            session.give_up_frames();
        }
    };
    const Restore restore{*this};
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

std::uint64_t Session::mesh_digest(const std::string& name) {
    fetching_ = &find_surface(name);
    schema::FetchMeshT request;
    request.surface = fetching_->id;
    const bus::Payload payload = bus::pack(request);
    slab_digests_.clear();
    begin_request();
    for (const bus::NodeId gp : machine_.gp_ids()) {
        machine_.send(gp, payload);
    }
    wait_for_gps("mesh of " + name);
    Digest digest;
    for (const auto& [slab, value] : slab_digests_) {
        digest.add(std::as_bytes(std::span(&value, 1)));
    }
    return digest.value();
}

}  // namespace pxpl5::host
