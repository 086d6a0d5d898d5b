#include "host/session/meshes.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <map>

#include "host/base/digest.hpp"
#include "host/base/error.hpp"
#include "host/base/nearest.hpp"
#include "host/session/transfer/detail.hpp"
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

std::uint32_t nearest_component(glm::dvec3 p_mm, const WeldedMesh& mesh,
                                const MeshComponents& parts, const VolumeGrid& grid) {
    return parts.of_triangle[nearest_point(mesh, grid, p_mm).value().triangle];
}

/// Returns the component nearest to the point; for a cavity, the component around the cavity.
std::size_t solid_at(glm::dvec3 p_mm, const WeldedMesh& mesh, const MeshComponents& parts,
                     const VolumeGrid& grid) {
    const std::uint32_t found = nearest_component(p_mm, mesh, parts, grid);
    return parts.components[found].cavity_of.value_or(found);
}

Shown shown_by(const ComponentFilter& filter, const WeldedMesh& mesh, const MeshComponents& parts,
               const VolumeGrid& grid) {
    const Cavities cavities = filter.fills_cavities ? Cavities::filled : Cavities::shown;
    switch (parts.components.empty() ? ComponentFilter::Kind::all : filter.kind) {
        case ComponentFilter::Kind::largest:
            return show_component(parts, largest_component(parts), cavities);
        case ComponentFilter::Kind::at_least_mm2:
            return show_at_least(parts, ComponentMeasure::area_mm2, filter.least, cavities);
        case ComponentFilter::Kind::at_least_ml:
            return show_at_least(parts, ComponentMeasure::volume_ml, filter.least, cavities);
        case ComponentFilter::Kind::at_point:
            return show_component(parts, solid_at(filter.p_mm, mesh, parts, grid), cavities);
        case ComponentFilter::Kind::all:
            break;
    }
    return Shown(mesh.triangles.size(), 1);
}

DrawnComponents drawn_by(const ComponentFilter& filter, const WeldedMesh& mesh,
                         const VolumeGrid& grid, const Pause& pause) {
    DrawnComponents drawn{find_components(mesh, grid, pause), {}};
    drawn.shown = shown_by(filter, mesh, drawn.parts, grid);
    return drawn;
}

}  // namespace

std::optional<double> DrawnComponents::volume_ml(OpenParts open) const {
    double ml = 0;
    for (const MeshComponent& part : parts.components) {
        if (is_drawn(part)) {
            if (!part.volume_mm3 || (!part.closed && open == OpenParts::without_volume)) {
                return std::nullopt;
            }
            ml += *part.volume_mm3 / 1000;
        }
    }
    return ml;
}

double DrawnComponents::area_mm2() const {
    double mm2 = 0;
    for (const MeshComponent& part : parts.components) {
        mm2 += is_drawn(part) ? part.area_mm2 : 0;
    }
    return mm2;
}

Surface& Meshes::surface(const std::string& name) const {
    if (volumes_.archive() != nullptr) {
        volumes_.volume();  // Throws, because an archive has no surfaces with names.
    }
    std::vector<std::string_view> names;
    for (Surface& surface : scene_.surfaces) {
        if (surface.name == name) {
            return surface;
        }
        names.push_back(surface.name);
    }
    throw RequestError(ExitCode::usage, fmt::format("there is no surface '{}'{}", name,
                                                    names.empty() ? "; there is none yet"
                                                                  : did_you_mean(name, names)));
}

void Meshes::fetch_parts(const Surface& surface, Wish wish,
                         const std::function<void(const bus::Message&)>& take) {
    schema::FetchMeshT request;
    request.surface = surface.id;
    request.origins = wish.origins;
    request.detail = static_cast<std::uint8_t>(wish.detail);
    conversation_.ask_cancelable(
        "mesh of " + surface.name, bus::pack(request),
        [id = surface.id, revision = surface.revision](const bus::Message& message) {
            const auto* part = message.as<schema::MeshPart>();
            return part != nullptr && part->surface() == id && part->revision() == revision;
        },
        take);
}

std::uint64_t Meshes::digest(const std::string& name) {
    std::map<std::uint32_t, std::uint64_t> slab_digests;
    fetch_parts(surface(name), {}, [&](const bus::Message& message) {
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

WeldedMesh Meshes::fetch(const std::string& name, bool cells) {
    const Surface& known = surface(name);
    MeshGather gather(grid(), known.id, known.revision);
    fetch_parts(known, {cells, 0}, [&gather](const bus::Message& part) { gather.add(part); });
    return gather.finish(pause_of(known));
}

SimplifiedMesh Meshes::fetch_simplified(const Surface& surface, int detail) {
    const Volume& volume = volumes_.volume();
    const std::string refusal =
        simplification_refusal(volume, static_cast<int>(conversation_.gps().size()));
    if (!refusal.empty()) {
        throw RequestError(ExitCode::failed, refusal);
    }
    BlockGather gather({surface.id, surface.revision, detail, volume.nz});
    fetch_parts(surface, {false, detail},
                [&gather](const bus::Message& part) { gather.add(part); });
    return gather.finish();
}

void Meshes::show(const std::string& name, const WeldedMesh& mesh, const Shown& shown) {
    const Surface& known = surface(name);
    conversation_.ask("mask of " + name, mask_message(mesh, shown, known.id, known.revision),
                      [&](const bus::Message& message) {
                          const auto* taken = message.as<schema::SurfaceBuilt>();
                          return taken != nullptr && taken->surface() == known.id &&
                                 taken->revision() == known.revision;
                      });
}

DrawnComponents Meshes::components(const Surface& surface) {
    return drawn_by(surface.components, fetch(surface.name), grid(), pause_of(surface));
}

Pause Meshes::pause_of(const Surface& surface) {
    return [this, what = "work on the mesh of " + surface.name] { conversation_.pause(what); };
}

ChosenComponent Meshes::component_at(const Surface& surface, glm::dvec3 p_mm) {
    const WeldedMesh mesh = fetch(surface.name);
    ChosenComponent chosen{find_components(mesh, grid(), pause_of(surface)), 0};
    chosen.number = nearest_component(p_mm, mesh, chosen.parts, grid());
    return chosen;
}

DrawnComponents Meshes::apply_filter(const Surface& surface) {
    const WeldedMesh whole = fetch(surface.name);
    DrawnComponents drawn = drawn_by(surface.components, whole, grid(), pause_of(surface));
    show(surface.name, whole, drawn.shown);
    return drawn;
}

WeldedMesh Meshes::fetch_drawn(const Surface& surface) {
    WeldedMesh whole = fetch(surface.name);
    if (surface.components.kind == ComponentFilter::Kind::all) {
        return whole;
    }
    return shown_part(whole, drawn_by(surface.components, whole, grid(), pause_of(surface)).shown);
}

std::vector<AtlasRow> Meshes::measure(std::span<const double> isovalues, CaseRule table) {
    volumes_.volume();  // Throws if no volume is loaded.
    schema::MeasureIsovaluesT request;
    request.isovalues.assign(isovalues.begin(), isovalues.end());
    request.table = table;
    // Sums in slab order, so that rounding does not depend on the machine.
    std::map<std::uint32_t, std::vector<schema::IsovalueCounts>> slabs;
    conversation_.ask_cancelable(
        "isovalues", bus::pack(request),
        [](const bus::Message& message) {
            return message.as<schema::IsovaluesMeasured>() != nullptr;
        },
        [&slabs](const bus::Message& message) {
            for (const auto* slab : *message.as<schema::IsovaluesMeasured>()->slabs()) {
                auto& counts = slabs[slab->slab()];
                for (const schema::IsovalueCounts* each : *slab->counts()) {
                    counts.push_back(*each);
                }
            }
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

}  // namespace pxpl5::host
