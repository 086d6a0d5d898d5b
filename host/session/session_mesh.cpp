// What a session reads back of surfaces.
#include <fmt/core.h>

#include <algorithm>
#include <span>

#include "host/base/digest.hpp"
#include "host/base/error.hpp"
#include "host/session/session.hpp"
#include "host/surface/mesh_gather.hpp"
#include "host/surface/mesh_mask.hpp"

namespace pxpl5::host {

namespace {

namespace schema = bus::schema;

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

Shown shown_by(const ComponentFilter& filter, const WeldedMesh& mesh, const MeshComponents& parts,
               const VolumeGrid& grid) {
    switch (parts.components.empty() ? ComponentFilter::Kind::all : filter.kind) {
        case ComponentFilter::Kind::largest:
            return show_component(parts, 0);
        case ComponentFilter::Kind::at_least_mm2:
            return show_at_least(parts, ComponentMeasure::area_mm2, filter.least);
        case ComponentFilter::Kind::at_least_ml:
            return show_at_least(parts, ComponentMeasure::volume_ml, filter.least);
        case ComponentFilter::Kind::at_point: {
            const std::optional<SurfacePoint> nearest = nearest_point(mesh, grid, filter.p_mm);
            return show_component(parts, parts.of_triangle[nearest.value().triangle]);
        }
        case ComponentFilter::Kind::all:
            break;
    }
    return Shown(mesh.triangles.size(), 1);
}

}  // namespace

void Session::fetch_mesh(const std::string& name, bool origins,
                         const std::function<void(const bus::Message&)>& take) {
    const Surface& surface = find_surface(name);
    schema::FetchMeshT request;
    request.surface = surface.id;
    request.origins = origins;
    ask_gps("mesh of " + name, bus::pack(request), [&](const bus::Message& message) {
        const auto* part = message.as<schema::MeshPart>();
        if (part == nullptr || part->surface() != surface.id ||
            part->revision() != surface.revision) {
            return false;
        }
        take(message);
        return true;
    });
}

std::uint64_t Session::mesh_digest(const std::string& name) {
    std::map<std::uint32_t, std::uint64_t> slab_digests;
    fetch_mesh(name, false, [&](const bus::Message& message) {
        for (const auto* mesh : *message.as<schema::MeshPart>()->slabs()) {
            slab_digests[mesh->slab()] = digest_of(*mesh);
        }
    });
    Digest digest;
    for (const auto& [slab, value] : slab_digests) {
        digest.add(std::as_bytes(std::span(&value, 1)));
    }
    return digest.value();
}

WeldedMesh Session::mesh(const std::string& name, bool cells) {
    const Surface& surface = find_surface(name);
    MeshGather gather(grid(), surface.id, surface.revision);
    fetch_mesh(name, cells, [&gather](const bus::Message& part) { gather.add(part); });
    return gather.finish();
}

void Session::show_triangles(const std::string& name, const WeldedMesh& mesh, const Shown& shown) {
    const Surface& surface = find_surface(name);
    ask_gps("mask of " + name, mask_message(mesh, shown, surface.id, surface.revision),
            [&](const bus::Message& message) {
                const auto* taken = message.as<schema::SurfaceBuilt>();
                return taken != nullptr && taken->surface() == surface.id &&
                       taken->revision() == surface.revision;
            });
}

std::pair<std::size_t, std::size_t> Session::apply_filter(const Surface& surface) {
    const WeldedMesh whole = mesh(surface.name);
    const MeshComponents parts = find_components(whole, grid());
    const Shown shown = shown_by(surface.components, whole, parts, grid());
    show_triangles(surface.name, whole, shown);
    std::set<std::uint32_t> drawn;
    for (std::size_t t = 0; t < shown.size(); ++t) {
        if (shown[t] != 0) {
            drawn.insert(parts.of_triangle[t]);
        }
    }
    return {parts.components.size(), drawn.size()};
}

WeldedMesh Session::drawn_mesh(const Surface& surface) {
    WeldedMesh whole = mesh(surface.name);
    if (surface.components.kind == ComponentFilter::Kind::all) {
        return whole;
    }
    const MeshComponents parts = find_components(whole, grid());
    return shown_part(whole, shown_by(surface.components, whole, parts, grid()));
}

std::pair<std::size_t, std::size_t> Session::set_components(const std::string& name,
                                                            const ComponentFilter& filter) {
    Surface& surface = find_surface(name);
    surface.components = filter;
    try {
        return apply_filter(surface);
    } catch (...) {
        surface.components = {};  // What is drawn is what is said.
        throw;
    }
}

std::vector<AtlasRow> Session::measure_isovalues(std::span<const double> isovalues,
                                                 CaseRule table) {
    volume();
    schema::MeasureIsovaluesT request;
    request.isovalues.assign(isovalues.begin(), isovalues.end());
    request.table = static_cast<CaseRule>(table);
    // Sums in slab order, so that rounding does not depend on which GP held which slab.
    std::map<std::uint32_t, std::vector<schema::IsovalueCounts>> slabs;
    ask_gps("isovalues", bus::pack(request), [&](const bus::Message& message) {
        const auto* measured = message.as<schema::IsovaluesMeasured>();
        if (measured == nullptr) {
            return false;
        }
        for (const auto* slab : *measured->slabs()) {
            auto& counts = slabs[slab->slab()];
            for (const schema::IsovalueCounts* each : *slab->counts()) {
                counts.push_back(*each);
            }
        }
        return true;
    });
    std::vector<AtlasRow> rows;
    for (const double isovalue : isovalues) {
        rows.push_back({isovalue, 0, 0, 0, 0});
    }
    for (const auto& [slab, counts] : slabs) {
        for (std::size_t i = 0; i < std::min(rows.size(), counts.size()); ++i) {
            rows[i].triangles += counts[i].triangles();
            rows[i].area_mm2 += counts[i].area_mm2();
            rows[i].volume_mm3 += counts[i].volume_mm3();
        }
    }
    return rows;
}

MeshComparison Session::compare(const std::string& name) {
    end_comparison(name);
    const Surface whole = find_surface(name);
    if (!whole.compared_with.empty()) {
        throw RequestError(ExitCode::usage, fmt::format("{} is a comparison itself", name));
    }
    if (scene.surfaces.size() + 2 > max_user_surfaces) {
        throw RequestError(
            ExitCode::usage,
            fmt::format("compare: {} surfaces and two more are {}, {} are the most",
                        scene.surfaces.size(), scene.surfaces.size() + 2, max_user_surfaces));
    }
    const std::string ours = name + ":watertight", theirs = name + ":lorensen1987";
    for (const std::string& made : {ours, theirs}) {
        if (surface(made)) {
            throw RequestError(ExitCode::usage,
                               fmt::format("compare: there is a surface '{}' already", made));
        }
    }
    constexpr Colour only_ours{64, 180, 166}, only_theirs{232, 128, 64};
    set_surface(ours, whole.isovalue, CaseRule::watertight, only_ours);
    find_surface(ours).compared_with = name;
    set_surface(theirs, whole.isovalue, CaseRule::lorensen1987, only_theirs);
    find_surface(theirs).compared_with = name;
    const WeldedMesh a = mesh(ours, true), b = mesh(theirs, true);
    MeshComparison comparison = compare_meshes(a, b, grid());
    show_triangles(ours, a, comparison.shown_a);
    show_triangles(theirs, b, comparison.shown_b);
    return comparison;
}

bool Session::end_comparison(const std::string& name) {
    std::vector<std::string> made;
    for (const Surface& surface : scene.surfaces) {
        if (surface.compared_with == name) {
            made.push_back(surface.name);
        }
    }
    for (const std::string& each : made) {
        remove_surface(each);
    }
    return !made.empty();
}

}  // namespace pxpl5::host
