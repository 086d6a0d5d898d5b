// What a session does with isosurfaces: has the GPs extract them, and keeps their reports.
#include <fmt/core.h>

#include <algorithm>
#include <utility>

#include "host/base/error.hpp"
#include "host/base/nearest.hpp"
#include "host/base/stopwatch.hpp"
#include "host/session/session.hpp"

namespace pxpl5::host {

namespace {

namespace schema = bus::schema;

/// Sums in slab order, so that rounding does not depend on which GP held which slab.
SurfaceReport sum_slabs(std::vector<schema::SlabCounts> slabs) {
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
    report.slabs = std::move(slabs);
    return report;
}

}  // namespace

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

void Session::set_style(const Surface& like) {
    Surface& surface = find_surface(like.name);
    surface.colour = like.colour;
    surface.visible = like.visible;
    surface.opacity = like.opacity;
    surface.cull_back = like.cull_back;
}

/// A surface's new revision, which the GPs extract.
struct Session::Building {
    explicit Building(Session& who) : session(who) {}
    ~Building() { session.answer_ = nullptr; }  // Which refers to this.
    Building(const Building&) = delete;
    Building& operator=(const Building&) = delete;

    Session& session;
    std::string name;
    schema::SetSurfaceT request;
    std::vector<schema::SlabCounts> slabs;
    std::int64_t memory_bytes = 0;
    std::int64_t start_ns = 0;

    /// Whether the message is a GP's part of it.
    bool take(const bus::Message& message) {
        const auto* built = message.as<schema::SurfaceBuilt>();
        if (built == nullptr || built->surface() != request.surface ||
            built->revision() != request.revision) {
            return false;
        }
        for (const schema::SlabCounts* slab : *built->slabs()) {
            slabs.push_back(*slab);
        }
        memory_bytes += static_cast<std::int64_t>(built->memory_bytes());
        return true;
    }
};

/// The surface of that name, added if there is none.
Surface& Session::put_surface(const std::string& name) {
    auto found = std::find_if(scene.surfaces.begin(), scene.surfaces.end(),
                              [&](const Surface& surface) { return surface.name == name; });
    if (found != scene.surfaces.end()) {
        return *found;
    }
    if (scene.surfaces.size() == max_user_surfaces) {
        throw RequestError(ExitCode::usage, fmt::format("{} surfaces are the most; remove one "
                                                        "before adding '{}'",
                                                        max_user_surfaces, name));
    }
    Surface added;
    added.name = name;
    added.id = next_surface_id_++;
    return scene.surfaces.emplace_back(added);
}

/// Has the GPs extract the surface's new revision; finish_surface() must follow.
void Session::begin_surface(Building& building, const std::string& name, double isovalue,
                            CaseRule table, Colour colour) {
    volume();
    Surface& surface = put_surface(name);
    surface.isovalue = isovalue;
    surface.table = table;
    surface.colour = colour;
    ++surface.revision;

    building.name = name;
    building.start_ns = now_ns();
    building.request.surface = surface.id;
    building.request.revision = surface.revision;
    building.request.isovalue = isovalue;
    building.request.table = static_cast<CaseRule>(table);
    begin_request([&building](const bus::Message& message) { return building.take(message); });
    send_to_gps(bus::pack(building.request));
}

/// Waits until all GPs have extracted it. A surface that cannot be extracted is removed; a fault of
/// the frame that shows it is none of the surface.
SurfaceReport Session::finish_surface(Building& building) {
    try {
        wait_for_gps("surface " + building.name);
    } catch (const RequestError&) {
        if (!fault_is_of_frame_) {  // The surface itself is well.
            remove_surface(building.name);
        }
        throw;
    }
    SurfaceReport report = sum_slabs(std::move(building.slabs));
    report.elapsed_ms = ms_since(building.start_ns);
    report.memory_bytes = building.memory_bytes;
    reports_.insert_or_assign(building.name, report);
    if (const Surface& built = find_surface(building.name);
        built.components.kind != ComponentFilter::Kind::all) {
        set_components(building.name, ComponentFilter(built.components));
    }
    return report;
}

SurfaceReport Session::set_surface(const std::string& name, double isovalue, CaseRule table,
                                   Colour colour) {
    Building building(*this);
    begin_surface(building, name, isovalue, table, colour);
    return finish_surface(building);
}

SweepReport Session::sweep(const std::string& name, std::span<const double> isovalues,
                           const TakeChange& take) {
    const Surface before = find_surface(name);
    // Otherwise what is drawn is known only when all of it is there; nor are several samples asked
    // for ahead.
    const bool is_ahead =
        before.components.kind == ComponentFilter::Kind::all && scene.samples == 1;
    std::vector<double> extractions_ms, pictures_ms;
    try {
        for (const double isovalue : isovalues) {
            Building building(*this);
            begin_surface(building, name, isovalue, before.table, before.colour);
            if (is_ahead) {
                submit_frame();
            }
            const SurfaceReport report = finish_surface(building);
            const Picture picture = is_ahead ? take_frame() : draw();
            pictures_ms.push_back(ms_since(building.start_ns));
            extractions_ms.push_back(report.elapsed_ms);
            take(static_cast<int>(pictures_ms.size()) - 1, picture, report);
        }
    } catch (const RequestError&) {
        give_up_frames();
        if (surface(name)) {  // What cannot be extracted is gone.
            set_surface(name, before.isovalue, before.table, before.colour);
        }
        throw;
    }
    set_surface(name, before.isovalue, before.table, before.colour);
    return {static_cast<int>(pictures_ms.size()), spread_of(std::move(extractions_ms)),
            spread_of(std::move(pictures_ms))};
}

void Session::remove_surface(const std::string& name) {
    const Surface& surface = find_surface(name);
    schema::RemoveSurfaceT request;
    request.surface = surface.id;
    send_to_gps(bus::pack(request));
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

}  // namespace pxpl5::host
