#include "tests/fuzz/message_ranges.hpp"

#include <set>

#include "ringbus/channel_model.hpp"
#include "tests/fuzz/documented.hpp"

namespace pxpl5::fuzz {

namespace {

using namespace bus::schema;

template <typename Mesh>
void triangles(const Mesh& mesh) {
    require(mesh.indices()->size() % 3 == 0, "whole triangles");
    for (const std::uint32_t index : *mesh.indices()) {
        require(index < mesh.vertices()->size(), "index of a vertex");
    }
    for (const auto* v : *mesh.vertices()) {
        finite("vertex", v->x(), v->y(), v->z(), v->nx(), v->ny(), v->nz());
    }
}

void check(const Hello& hello) {
    known("role", hello.role());
}

void check(const Topology& topology) {
    in("nodes", topology.nodes()->size(), 1, max_nodes);
    in("ring_channels", topology.ring_channels(), 1, bus::max_channels);
    known("recording", topology.recording());
    std::set<std::uint16_t> ids;
    each(topology.nodes(), [&](const NodeInfo& node) {
        known("role", node.role());
        require(ids.insert(node.id()).second, "a node that is there twice");
    });
}

void check(const Fault& fault) {
    known("code", fault.code());
    in("request", fault.request(), 0, static_cast<int>(Body::MAX));
}

void check(const ImportVolume& import) {
    triple("spacing_mm", import.spacing_mm(), min_spacing_mm, max_spacing_mm);
    triple("crop_first", import.crop_first(), 0, max_volume_voxels);
    triple("crop_size", import.crop_size(), 1, max_volume_voxels);
    triple("resample_size", import.resample_size(), 1, max_volume_voxels);
    triple("resample_spacing_mm", import.resample_spacing_mm(), min_spacing_mm, max_spacing_mm);
    triple("origin_mm", import.origin_mm(), -max_scene_mm, max_scene_mm);
    in("smooth_mm", import.smooth_mm(), 0, max_smooth_mm);
    in("volumes", import.volumes(), 1, max_frames);
    known("gradient", import.gradient());
    require((import.crop_first() == nullptr) == (import.crop_size() == nullptr), "crop");
    if (const RawLayout* raw = import.raw()) {
        in("nx", raw->nx(), 1, max_volume_voxels);
        in("ny", raw->ny(), 1, max_volume_voxels);
        in("nz", raw->nz(), 1, max_volume_voxels);
    }
}

void check(const VolumeHeader& header) {
    in("nx", header.nx(), min_volume_voxels, max_volume_voxels);
    in("ny", header.ny(), min_volume_voxels, max_volume_voxels);
    in("nz", header.nz(), 1, max_volume_voxels);
    known("type", header.type());
    known("gradient", header.gradient());
    finite("voxel_to_patient", *header.voxel_to_patient());
    finite("minimum and maximum", header.minimum(), header.maximum());
    require(header.minimum() <= header.maximum(), "minimum and maximum");
    in("slabs_per_set", header.slabs_per_set(), 1, max_volume_voxels);
    require(header.slice_places() == nullptr || header.slice_places()->size() == header.nz(),
            "slice_places");
    ascending("slice_places", header.slice_places());
    for (flatbuffers::uoffset_t i = 0; i < length(header.slice_places()); ++i) {
        finite("slice_places", header.slice_places()->Get(i));
    }
    ascending("gap_slabs", header.gap_slabs());
    for (flatbuffers::uoffset_t i = 0; i < length(header.gap_slabs()); ++i) {
        in("gap_slabs", header.gap_slabs()->Get(i), 0, max_slab);
    }
    each(header.findings(), [](const Finding& finding) { known("finding", finding.kind()); });
    in("windows", length(header.windows()), 0, max_windows);
    each(header.windows(), [](const NamedWindow& window) {
        in("width of a window", window.width(), least_window, most_window);
        in("level of a window", window.level(), -most_window, most_window);
    });
    in("suv_per_value", header.suv_per_value(), 0, std::numeric_limits<double>::max());
    in("frames", header.frames(), 1, max_frames);
    in("frame", header.frame(), 1, header.frames());
    in("frame_ms", header.frame_ms(), 0, max_frame_ms);
    require(length(header.times_ms()) == 0 || header.times_ms()->size() == header.frames(),
            "times_ms");
    require(length(header.times_ms()) == 0 || header.frame_ms() == 0, "frame_ms beside times_ms");
    require(length(header.times_ms()) != 1, "times_ms of one volume");
    ascending("times_ms", header.times_ms());
    for (flatbuffers::uoffset_t i = 0; i < length(header.times_ms()); ++i) {
        in("times_ms", header.times_ms()->Get(i), 0, i == 0 ? 0 : max_frame_ms);
    }
}

void check(const Slices& slices) {
    in("slice_count", slices.slice_count(), 1, max_volume_voxels);
    in("last slice", std::uint64_t{slices.first_slice()} + slices.slice_count(), 1,
       max_volume_voxels);
    require(slices.values()->size() % slices.slice_count() == 0, "whole slices");
}

void check(const Mark& mark) {
    known("kind of mark", mark.kind());
    const int least = mark.kind() == MarkKind::line ? 2 : mark.kind() == MarkKind::area ? 3 : 1;
    in("points", mark.points()->size(), least, max_mark_points);
    for (const PicturePoint* point : *mark.points()) {
        in("x", point->x(), -max_mark_px, max_mark_px);
        in("y", point->y(), -max_mark_px, max_mark_px);
    }
    in("width_px", mark.width_px(), 0, max_mark_px);
    in("height_px", mark.height_px(), 0, max_mark_px);
    in("align_x", mark.align_x(), 0, 1);
    in("align_y", mark.align_y(), 0, 1);
}

void check(const ExportPicture& picture) {
    in("width", picture.width(), 1, max_export_px);
    in("height", picture.height(), 1, max_export_px);
    in("count", picture.count(), 1, max_animation_pictures);
    in("delay_ms", picture.delay_ms(), 1, max_delay_ms);
    require(picture.rgba()->size() ==
                std::uint64_t{4} * picture.width() * picture.height() * picture.count(),
            "rgba");
    in("marks", length(picture.marks()), 0, max_marks);
    each(picture.marks(), [](const Mark& mark) { check(mark); });
}

void check(const ExportMesh& mesh) {
    in("surfaces", mesh.surfaces()->size(), 1, max_surfaces);
    known("axes", mesh.axes());
    in("keep", mesh.keep(), 0, 1);
    in("error_mm", mesh.error_mm(), 0, max_error_mm);
    each(mesh.surfaces(), [](const ExportSurface& surface) { triangles(surface); });
}

void check(const MeshContent& mesh) {
    each(mesh.surfaces(), [](const ExportSurface& surface) { triangles(surface); });
}

void check(const SetSurface& set) {
    finite("isovalue", set.isovalue());
    known("table", set.table());
}

void check(const SurfaceBuilt& built) {
    std::int64_t last = -1;
    for (const SlabCounts* slab : *built.slabs()) {
        in("slab", slab->slab(), last + 1, max_slab);
        in("cells_active", slab->cells_active(), 0, slab->cells_visited());
        in("edges_crossed", slab->edges_crossed(), 0, slab->edges_visited());
        finite("area and volume", slab->area_mm2(), slab->volume_mm3());
        last = slab->slab();
    }
}

void check(const FetchVoxels& fetch) {
    const VoxelBox& box = *fetch.box();
    in("x", box.x(), 0, max_volume_voxels - 1);
    in("y", box.y(), 0, max_volume_voxels - 1);
    in("z", box.z(), 0, max_volume_voxels - 1);
    in("nx", box.nx(), 1, max_volume_voxels - box.x());
    in("ny", box.ny(), 1, max_volume_voxels - box.y());
    in("nz", box.nz(), 1, max_volume_voxels - box.z());
}

void check(const VoxelValues& found) {
    const std::size_t slices = found.slices()->size();
    in("slices", slices, 0, max_volume_voxels);
    ascending("slices", found.slices());
    for (const std::uint32_t z : *found.slices()) {
        in("slice", z, 0, max_volume_voxels - 1);
    }
    require(slices == 0 ? found.values()->size() == 0 : found.values()->size() % slices == 0,
            "whole slices");
}

void check(const FetchMesh& fetch) {
    in("detail", fetch.detail(), 0, max_detail);
    require(fetch.detail() == 0 || !fetch.origins(), "origins of a simplified mesh");
}

void check(const MeshPart& part) {
    in("detail", part.detail(), 0, max_detail);
    require(std::isfinite(part.moved_mm()) && part.moved_mm() >= 0, "moved_mm");
    each(part.slabs(), [](const SlabMesh& slab) {
        in("slab", slab.slab(), 0, max_slab);
        require(slab.keys()->size() == slab.vertices()->size(), "keys");
        triangles(slab);
        require(slab.origins() == nullptr || slab.origins()->size() == slab.indices()->size() / 3,
                "origins of triangles");
    });
}

void check(const MaskSurface& mask) {
    each(mask.slabs(), [](const SlabMask& slab) { in("slab", slab.slab(), 0, max_slab); });
}

void check(const MeasureIsovalues& measure) {
    in("isovalues", measure.isovalues()->size(), 1, max_isovalues);
    ascending("isovalues", measure.isovalues());
    for (const double value : *measure.isovalues()) {
        finite("isovalue", value);
    }
    known("table", measure.table());
}

void check(const IsovaluesMeasured& measured) {
    std::int64_t last = -1;
    each(measured.slabs(), [&](const SlabCurve& slab) {
        in("slab", slab.slab(), last + 1, max_slab);
        last = slab.slab();
        for (const IsovalueCounts* counts : *slab.counts()) {
            finite("area and volume", counts->area_mm2(), counts->volume_mm3());
        }
    });
}

void check(const SceneBegin& begin) {
    in("surfaces", begin.surfaces()->size(), 0, max_surfaces);
    const std::set<std::uint16_t> once(begin.surfaces()->begin(), begin.surfaces()->end());
    require(once.size() == begin.surfaces()->size(), "a surface that is there twice");
}

void check(const ScenePart& part) {
    in("slab", part.slab(), 0, max_scene_slab);
    triangles(part);
    for (const MeshVertex* v : *part.vertices()) {
        for (const float place : {v->x(), v->y(), v->z()}) {
            in("coordinate", place, -max_scene_mm, max_scene_mm);
        }
    }
    for (const SceneSphere* s : *part.spheres()) {
        for (const float place : {s->x(), s->y(), s->z()}) {
            in("center", place, -max_scene_mm, max_scene_mm);
        }
        require(s->radius() > 0 && s->radius() <= max_scene_mm, "radius");
    }
    for (const SceneLine* l : *part.lines()) {
        for (const float place : {l->ax(), l->ay(), l->az(), l->bx(), l->by(), l->bz()}) {
            in("end of a line", place, -max_scene_mm, max_scene_mm);
        }
    }
}

void check(const ArchiveContent& content) {
    in("materials", content.materials()->size(), 1, max_surfaces);
    finite("box", content.low()->x(), content.low()->y(), content.low()->z(), content.high()->x(),
           content.high()->y(), content.high()->z());
    require(content.low()->x() <= content.high()->x() &&
                content.low()->y() <= content.high()->y() &&
                content.low()->z() <= content.high()->z(),
            "low and high");
    in("structures", content.structures(), 1, max_archive_structures);
    in("posted", content.posted(), 1, content.structures());
    in("specular", content.specular(), 0, 1);
    in("specular_power", content.specular_power(), 0, max_specular_power);
    in("notes", length(content.notes()), 0, max_archive_notes);
    each(content.notes(), [](const flatbuffers::String& note) {
        in("length of a note", note.size(), 0, max_note_length);
    });
    std::uint64_t slab = 0, primitives = 0;
    each(content.parts(), [&](const ScenePart& part) {
        check(part);
        require(part.scene() == 0 && part.slab() == slab++, "number of a part");
        in("material", part.surface(), 0, content.materials()->size() - 1);
        primitives += part.indices()->size() / 3 + std::uint64_t{part.spheres()->size()} +
                      part.lines()->size();
    });
    in("primitives", primitives, 1, max_archive_primitives);
}

/// Checks the body if it is one of these tables.
template <typename... Tables>
void check_model_of(const bus::Message& message) {
    (if_kind<Tables>(message, [](const Tables& body) { check(body); }), ...);
}

}  // namespace

void require_documented_ranges(const bus::Message& message) {
    check_model_of<Hello, Topology, Fault, ImportVolume, VolumeHeader, Slices, ExportPicture,
                   ExportMesh, MeshContent, SetSurface, SurfaceBuilt, FetchMesh, MeshPart,
                   MaskSurface, MeasureIsovalues, IsovaluesMeasured, SceneBegin, ScenePart,
                   ArchiveContent, FetchVoxels, VoxelValues>(message);
    require_documented_frame(message);
}

}  // namespace pxpl5::fuzz
