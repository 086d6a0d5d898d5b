#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <set>
#include <utility>

#include "ringbus/range_check.hpp"
#include "ringbus/ranges.hpp"

namespace pxpl5::bus {

namespace {

std::string range_of(const schema::Mark& mark) {
    const std::size_t least = mark.kind() == MarkKind::line   ? 2
                              : mark.kind() == MarkKind::area ? 3
                                                              : 1;
    Check check;
    check.known("kind of mark", mark.kind())
        .within("points of a mark", mark.points()->size(), least, max_mark_points)
        .within("width_px", mark.width_px(), 0.0F, max_mark_px)
        .within("height_px", mark.height_px(), 0.0F, max_mark_px)
        .within("align_x", mark.align_x(), 0.0F, 1.0F)
        .within("align_y", mark.align_y(), 0.0F, 1.0F);
    for (const auto* point : *mark.points()) {
        check.within("x of a mark", point->x(), -max_mark_px, max_mark_px)
            .within("y of a mark", point->y(), -max_mark_px, max_mark_px);
    }
    return check.reason();
}

std::string range_of(const schema::ExportPicture& picture, Elements elements) {
    Check check;
    check.within("width", picture.width(), 1, max_export_px)
        .within("height", picture.height(), 1, max_export_px)
        .within("count", picture.count(), 1, max_animation_pictures)
        .within("delay_ms", picture.delay_ms(), 1, max_delay_ms)
        .equal("size of rgba", std::size_t{picture.rgba()->size()},
               std::size_t{picture.width()} * picture.height() * picture.count() * 4)
        .within("number of marks", size_of(picture.marks()), 0, max_marks);
    if (check.reason().empty() && picture.marks() != nullptr) {
        for (const auto* mark : *picture.marks()) {
            if (!elements.take(check, mark->points()->size())) {
                break;
            }
            check.add(range_of(*mark));
        }
    }
    return check.reason();
}

std::string range_of(const schema::SetSurface& surface) {
    return Check().finite("isovalue", surface.isovalue()).known("table", surface.table()).reason();
}

std::string range_of(const schema::SurfaceBuilt& built) {
    Check check;
    const schema::SlabCounts* last = nullptr;
    for (const auto* slab : *built.slabs()) {
        check.within("slab", slab->slab(), last == nullptr ? 0U : last->slab() + 1, max_slab)
            .at_most("cells_active", slab->cells_active(), slab->cells_visited())
            .at_most("edges_crossed", slab->edges_crossed(), slab->edges_visited())
            .finite("area_mm2", slab->area_mm2())
            .finite("volume_mm3", slab->volume_mm3());
        last = slab;
    }
    return check.at_most("left_out", built.left_out(), built.slabs()->size())
        .at_most("gps_to_hold_all", built.gps_to_hold_all(), max_nodes_per_role)
        .reason();
}

bool is_finite(const schema::MeshVertex& v) {
    return std::isfinite(v.x()) && std::isfinite(v.y()) && std::isfinite(v.z()) &&
           std::isfinite(v.nx()) && std::isfinite(v.ny()) && std::isfinite(v.nz());
}

/// Checks the triangles of a SlabMesh or an ExportSurface.
template <typename Table>
void check_triangles(Check& check, const Table& mesh, Elements& elements) {
    const auto& vertices = *mesh.vertices();
    const auto& indices = *mesh.indices();
    if (!elements.take(check, std::size_t{vertices.size()} + indices.size())) {
        return;
    }
    check.equal("indices beyond whole triangles", indices.size() % 3, 0U);
    const auto outside = std::find_if(indices.begin(), indices.end(),
                                      [&](std::uint32_t i) { return i >= vertices.size(); });
    if (outside != indices.end()) {
        check.add(fmt::format("index {} of {} vertices", *outside, vertices.size()));
    }
    for (flatbuffers::uoffset_t i = 0; i < vertices.size(); ++i) {
        if (!is_finite(*vertices.Get(i))) {
            check.add(fmt::format("vertex {} is not finite", i));
        }
    }
}

std::string range_of(const schema::SlabMesh& mesh, Elements& elements) {
    Check check;
    check.at_most("slab", mesh.slab(), max_slab)
        .equal("number of keys", mesh.keys()->size(), mesh.vertices()->size());
    check_triangles(check, mesh, elements);
    if (mesh.origins() != nullptr) {
        check.equal("number of origins", mesh.origins()->size(), mesh.indices()->size() / 3);
    }
    return check.reason();
}

std::string range_of(const schema::FetchMesh& fetch) {
    Check check;
    check.at_most("detail", fetch.detail(), max_detail);
    if (fetch.detail() > 0) {
        check.equal("origins of a simplified mesh", fetch.origins(), false);
    }
    return check.reason();
}

std::string range_of(const schema::ExportMesh& mesh, Elements elements) {
    Check check;
    check.within("number of surfaces", mesh.surfaces()->size(), 1, max_surfaces)
        .known("axes", mesh.axes())
        .within("keep", mesh.keep(), 0.0F, 1.0F)
        .within("error_mm", mesh.error_mm(), 0.0, max_error_mm);
    for (const auto* surface : *mesh.surfaces()) {
        check_triangles(check, *surface, elements);
    }
    return check.reason();
}

std::string range_of(const schema::MeshContent& mesh, Elements elements) {
    Check check;
    for (const auto* surface : *mesh.surfaces()) {
        check_triangles(check, *surface, elements);
    }
    return check.reason();
}

std::string range_of(const schema::MaskSurface& mask) {
    Check check;
    for (const auto* slab : *mask.slabs()) {
        check.at_most("slab", slab->slab(), max_slab);
    }
    return check.reason();
}

std::string range_of(const schema::MeasureIsovalues& measure) {
    const auto& isovalues = *measure.isovalues();
    Check check;
    check.within("number of isovalues", isovalues.size(), 1, max_isovalues)
        .known("table", measure.table());
    for (flatbuffers::uoffset_t i = 0; i < isovalues.size(); ++i) {
        check.finite("isovalue", isovalues.Get(i));
        if (i > 0 && !(isovalues.Get(i) > isovalues.Get(i - 1))) {
            check.add(
                fmt::format("isovalue {} comes after {}", isovalues.Get(i), isovalues.Get(i - 1)));
        }
    }
    return check.reason();
}

std::string range_of(const schema::IsovaluesMeasured& measured, Elements elements) {
    Check check;
    const schema::SlabCurve* last = nullptr;
    for (const auto* slab : *measured.slabs()) {
        if (!elements.take(check, slab->counts()->size())) {
            break;
        }
        check.within("slab", slab->slab(), last == nullptr ? 0U : last->slab() + 1, max_slab);
        for (const auto* counts : *slab->counts()) {
            check.finite("area_mm2", counts->area_mm2()).finite("volume_mm3", counts->volume_mm3());
        }
        last = slab;
    }
    return check.reason();
}

std::string range_of(const schema::MeshPart& part, Elements elements) {
    Check check;
    check.at_most("detail", part.detail(), max_detail).length("moved_mm", part.moved_mm());
    for (const auto* slab : *part.slabs()) {
        check.add(range_of(*slab, elements));
    }
    return check.reason();
}

std::string range_of(const schema::SceneBegin& begin) {
    const auto& surfaces = *begin.surfaces();
    return Check()
        .within("number of surfaces", surfaces.size(), 0, max_surfaces)
        .equal("number of different surfaces",
               std::set<std::uint16_t>(surfaces.begin(), surfaces.end()).size(),
               std::size_t{surfaces.size()})
        .reason();
}

std::string range_of(const schema::ScenePart& part, Elements& elements) {
    const auto& vertices = *part.vertices();
    const auto& indices = *part.indices();
    Check check;
    if (!elements.take(check, std::size_t{vertices.size()} + indices.size() +
                                  part.spheres()->size() + part.lines()->size())) {
        return check.reason();
    }
    check.at_most("slab", part.slab(), max_scene_slab)
        .equal("indices beyond whole triangles", indices.size() % 3, 0U);
    const auto outside = std::find_if(indices.begin(), indices.end(),
                                      [&](std::uint32_t i) { return i >= vertices.size(); });
    if (outside != indices.end()) {
        check.add(fmt::format("index {} of {} vertices", *outside, vertices.size()));
    }
    const auto place = [&check](const char* field, std::initializer_list<float> values) {
        for (const float value : values) {
            check.within(field, value, -max_scene_mm, max_scene_mm);
        }
    };
    for (const auto* v : vertices) {
        place("a vertex's coordinate", {v->x(), v->y(), v->z()});
        for (const float value : {v->nx(), v->ny(), v->nz()}) {
            check.within("a normal's component", value, -1.001F, 1.001F);
        }
    }
    for (const auto* s : *part.spheres()) {
        place("a sphere's coordinate", {s->x(), s->y(), s->z()});
        check.within("a sphere's radius", s->radius(), std::numeric_limits<float>::min(),
                     max_scene_mm);
    }
    for (const auto* l : *part.lines()) {
        place("a line's coordinate", {l->ax(), l->ay(), l->az(), l->bx(), l->by(), l->bz()});
    }
    return check.reason();
}

/// Checks the box, the counts and the notes of an archive.
void check_facts(Check& check, const schema::ArchiveContent& content) {
    const schema::ScenePoint &low = *content.low(), &high = *content.high();
    for (const auto& [from, to] : {std::pair(low.x(), high.x()), std::pair(low.y(), high.y()),
                                   std::pair(low.z(), high.z())}) {
        check.finite("low", from).finite("high", to).at_most("low", from, to);
    }
    check.within("structures", content.structures(), 1, max_archive_structures)
        .within("posted", content.posted(), 1, content.structures())
        .within("specular", content.specular(), 0.0, 1.0)
        .at_most("specular_power", content.specular_power(), max_specular_power)
        .at_most("number of notes", size_of(content.notes()), max_archive_notes);
    if (check.reason().empty() && content.notes() != nullptr) {
        for (const auto* note : *content.notes()) {
            check.at_most("length of a note", note->size(), max_note_length);
        }
    }
}

std::string range_of(const schema::ArchiveContent& content, Elements elements) {
    Check check;
    check.within("number of materials", content.materials()->size(), 1, max_surfaces);
    check_facts(check, content);
    std::uint64_t primitives = 0;
    std::uint32_t slab = 0;
    for (const auto* part : *content.parts()) {
        if (!check.reason().empty()) {
            break;  // No more lists, which parts may share.
        }
        check.equal("scene of a part", part->scene(), 0U)
            .equal("slab of a part", part->slab(), slab++)
            .within("material of a part", part->surface(), 0, content.materials()->size() - 1);
        check.add(range_of(*part, elements));
        primitives += part->indices()->size() / 3;
        primitives += std::uint64_t{part->spheres()->size()} + part->lines()->size();
    }
    return check.within("number of primitives", primitives, 1, max_archive_primitives).reason();
}

}  // namespace

std::string model_out_of_range(const schema::Message& message, std::size_t body_bytes) {
    Elements elements(body_bytes);
    switch (message.body_type()) {
        case Body::ExportPicture:
            return range_of(*message.body_as_ExportPicture(), elements);
        case Body::SetSurface:
            return range_of(*message.body_as_SetSurface());
        case Body::SurfaceBuilt:
            return range_of(*message.body_as_SurfaceBuilt());
        case Body::FetchMesh:
            return range_of(*message.body_as_FetchMesh());
        case Body::MeshPart:
            return range_of(*message.body_as_MeshPart(), elements);
        case Body::SceneBegin:
            return range_of(*message.body_as_SceneBegin());
        case Body::ScenePart:
            return range_of(*message.body_as_ScenePart(), elements);
        case Body::ArchiveContent:
            return range_of(*message.body_as_ArchiveContent(), elements);
        case Body::MaskSurface:
            return range_of(*message.body_as_MaskSurface());
        case Body::MeasureIsovalues:
            return range_of(*message.body_as_MeasureIsovalues());
        case Body::IsovaluesMeasured:
            return range_of(*message.body_as_IsovaluesMeasured(), elements);
        case Body::ExportMesh:
            return range_of(*message.body_as_ExportMesh(), elements);
        case Body::MeshContent:
            return range_of(*message.body_as_MeshContent(), elements);
        default:
            return volume_out_of_range(message, body_bytes);
    }
}

}  // namespace pxpl5::bus
