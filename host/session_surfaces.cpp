// What a session does with isosurfaces: has the GPs extract them, and keeps their reports.
#include <fmt/core.h>

#include <algorithm>

#include "host/error.hpp"
#include "host/nearest.hpp"
#include "host/session.hpp"
#include "host/stopwatch.hpp"

namespace pxpl5::host {

namespace {

namespace schema = bus::schema;

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
        Surface added;
        added.name = name;
        added.id = next_surface_id_++;
        scene.surfaces.push_back(added);
        found = scene.surfaces.end() - 1;
    }
    found->isovalue = isovalue;
    found->table = table;
    found->colour = colour;
    ++found->revision;

    const std::int64_t start_ns = now_ns();
    schema::SetSurfaceT request;
    request.surface = found->id;
    request.revision = found->revision;
    request.isovalue = isovalue;
    request.table = static_cast<schema::CaseTable>(table);
    std::vector<schema::SlabCounts> slabs;
    std::int64_t memory_bytes = 0;
    const auto take = [&](const bus::Message& message) {
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
    };
    try {
        ask_gps("surface " + name, bus::pack(request), take);
    } catch (const RequestError&) {
        remove_surface(name);
        throw;
    }
    SurfaceReport report = sum_slabs(slabs);
    report.elapsed_ms = ms_since(start_ns);
    report.memory_bytes = memory_bytes;
    reports_.insert_or_assign(name, report);
    if (const Surface& built = find_surface(name);
        built.components.kind != ComponentFilter::Kind::all) {
        set_components(name, ComponentFilter(built.components));
    }
    return report;
}

void Session::remove_surface(const std::string& name) {
    const Surface& surface = find_surface(name);
    schema::RemoveSurfaceT request;
    request.surface = surface.id;
    const bus::Payload payload = bus::pack(request);
    for (const bus::NodeId gp : machine_.gp_ids()) {
        machine_.send(gp, payload);
    }
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
