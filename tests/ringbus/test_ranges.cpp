#include "ringbus/rules/regions.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include "tests/ringbus/examples/examples.hpp"
#include "tests/ringbus/wire_bytes.hpp"

using namespace pxpl5;
using namespace pxpl5::bus;
using namespace pxpl5::test;

namespace {

constexpr double nan_value = std::numeric_limits<double>::quiet_NaN();

/// The refusal of a T after `spoil` changed it. The unchanged T must be accepted.
template <typename T, typename Spoil>
std::string refusal_of(const Spoil& spoil) {
    for (const Payload& payload : one_of_each_kind()) {
        const Message message = WireBytes(payload).read();
        if (const auto* body = message.as<typename T::TableType>()) {
            T object;
            body->UnPackTo(&object);
            REQUIRE(refusal(pack(object)) == "");
            spoil(object);
            return refusal(pack(object));
        }
    }
    return "no example";
}

#define CHECK_REFUSED(Type, change, text)                                           \
    do {                                                                            \
        const std::string said = refusal_of<schema::Type>([](auto& m) { change; }); \
        CHECK_MESSAGE(contains(said, text), said);                                  \
    } while (false)

/// Three surfaces, the last `count` of which are slice planes.
void planes(schema::DrawFrameT& m, std::size_t count,
            schema::SlicePlane plane = schema::SlicePlane(2, 4095, -1, 1)) {
    m.surfaces.assign(3, schema::SurfaceDraw(plane_surface_id, 0, schema::Rgb(), false,
                                             SlabChoice::all, full_opacity, 0, 0));
    m.planes.assign(count, plane);
}

}  // namespace

TEST_SUITE("ringbus/ranges") {
    TEST_CASE("a node's introduction and the topology") {
        CHECK_REFUSED(HelloT, m.role = static_cast<schema::Role>(99),
                      "role is 99, allowed are 0 .. 4");
        CHECK_REFUSED(TopologyT, m.nodes.clear(), "number of nodes is 0");
        CHECK_REFUSED(TopologyT, m.nodes[2]->id = 1, "node 1 is there twice");
        CHECK_REFUSED(TopologyT, m.nodes[2]->role = static_cast<schema::Role>(99), "role is 99");
        CHECK_REFUSED(TopologyT, m.ring_channels = 0, "ring channels is 0, allowed are 1 .. 64");
        CHECK_REFUSED(FaultT, m.code = static_cast<schema::FaultCode>(99), "code is 99");
        CHECK_REFUSED(FaultT, m.request = 999, "request is 999");
    }

    TEST_CASE("a volume") {
        CHECK_REFUSED(VolumeHeaderT, m.nx = 1, "nx is 1, allowed are 2 .. 4096");
        CHECK_REFUSED(VolumeHeaderT, m.ny = 4097, "ny is 4097");
        CHECK_REFUSED(VolumeHeaderT, m.nz = 0, "nz is 0");
        CHECK_REFUSED(VolumeHeaderT, m.type = static_cast<Scalar>(99), "type is 99");
        CHECK_REFUSED(VolumeHeaderT, m.minimum = 3001, "minimum is 3001, allowed are at most 3000");
        CHECK_REFUSED(VolumeHeaderT, m.maximum = nan_value, "maximum is nan");
        CHECK_REFUSED(VolumeHeaderT, m.voxel_to_patient->mutable_m()->Mutate(7, nan_value),
                      "voxel_to_patient holds nan");
        CHECK_REFUSED(SlicesT, m.slice_count = 0, "slice_count is 0");
        CHECK_REFUSED(SlicesT, m.first_slice = 4095, "first_slice is 4095, allowed are 0 .. 4094");
        CHECK_REFUSED(SlicesT, m.slice_count = 3, "bytes beyond whole slices is 2, expected 0");
        CHECK_REFUSED(VolumeHeaderT, m.slice_places.pop_back(), "slice_places is 5, expected 6");
        CHECK_REFUSED(VolumeHeaderT, m.slice_places[2] = 1, "slice_places 2 is 1, after 1");
        CHECK_REFUSED(VolumeHeaderT, m.gap_slabs.push_back(3), "gap_slabs is 3, allowed are 4");
        CHECK_REFUSED(VolumeHeaderT, m.slabs_per_set = 0, "slabs_per_set is 0");
        CHECK_REFUSED(VolumeHeaderT, m.gradient = static_cast<GradientKernel>(2), "gradient is 2");
        CHECK_REFUSED(VolumeHeaderT, m.suv_per_value = -1, "suv_per_value is -1");
        CHECK_REFUSED(VolumeHeaderT, m.frames = 0, "frames is 0");
        CHECK_REFUSED(VolumeHeaderT, m.frame = 6, "frame is 6, allowed are 1 .. 5");
        CHECK_REFUSED(VolumeHeaderT, m.frame_ms = nan_value, "frame_ms is nan");
        CHECK_REFUSED(VolumeHeaderT, m.frame_ms = 30, "frame_ms beside times_ms is 30, expected 0");
        CHECK_REFUSED(VolumeHeaderT, m.times_ms.pop_back(), "times_ms is 4, expected 5");
        CHECK_REFUSED(VolumeHeaderT, m.times_ms[0] = 1, "times_ms 0 is 1, expected 0");
        CHECK_REFUSED(VolumeHeaderT, m.times_ms[3] = 40, "times_ms 3 is 40, after 40");
        CHECK_REFUSED(VolumeHeaderT, m.times_ms[4] = nan_value, "times_ms is nan");
        CHECK_REFUSED(VolumeHeaderT, m.windows[0]->width = 0, "width of a window is 0");
        CHECK_REFUSED(VolumeHeaderT, m.windows[0]->level = nan_value, "level of a window is nan");
        CHECK_REFUSED(VolumeHeaderT, m.findings[0]->kind = static_cast<FindingKind>(99),
                      "kind of finding is 99");
        CHECK_REFUSED(ImportVolumeT, m.spacing_mm[1] = 0, "spacing_mm is 0");
        CHECK_REFUSED(ImportVolumeT, m.crop_size.pop_back(), "crop_size is 2, expected 3");
        CHECK_REFUSED(ImportVolumeT, m.crop_first.clear(), "crop_first and crop_size together");
        CHECK_REFUSED(ImportVolumeT, m.resample_size[2] = 5000, "resample_size is 5000");
        CHECK_REFUSED(ImportVolumeT, m.smooth_mm = nan_value, "smooth_mm is nan");
        CHECK_REFUSED(ImportVolumeT, m.raw->ny = 0, "ny is 0");
        CHECK_REFUSED(ImportVolumeT, m.read = static_cast<ReadBy>(3), "read is 3");
        CHECK_REFUSED(ImportVolumeT, m.gradient = static_cast<GradientKernel>(2), "gradient is 2");
        CHECK_REFUSED(ImportVolumeT, m.reduced_bytes = 0, "reduced_bytes is 0");
        CHECK_REFUSED(ImportVolumeT, m.volumes = 0, "volumes is 0");
        CHECK_REFUSED(ImportVolumeT, m.volumes = 1'000'001, "volumes is 1000001");
        CHECK_REFUSED(VolumeHeaderT, m.stored->files[0]->path = "scan.raw",
                      "path is absolute is false");
        CHECK_REFUSED(VolumeHeaderT, m.stored->files[0]->path += '\0', "has a zero byte is true");
        CHECK_REFUSED(VolumeHeaderT, m.stored->component = static_cast<Component>(99),
                      "component is 99");
        CHECK_REFUSED(VolumeHeaderT, m.stored->bits_stored = 33, "bits_stored is 33");
        CHECK_REFUSED(VolumeHeaderT, m.stored->files.clear(), "files of a volume is 0");
        CHECK_REFUSED(VolumeHeaderT, m.stored->files[0]->slope = nan_value, "slope is nan");
        CHECK_REFUSED(VolumeHeaderT, m.stored->files[0]->offset = 501, "offset is 501");
        CHECK_REFUSED(VolumeHeaderT, ++m.stored->files[0]->offset, "bytes of the values is 480");
        CHECK_REFUSED(VolumeHeaderT, m.stored->files[0]->slices = 0, "slices of a file is 0");
        CHECK_REFUSED(VolumeHeaderT, m.stored->files[0]->slices = 5,
                      "slices of all files is 5, expected 6");
        CHECK_REFUSED(VolumeHeaderT, m.reduction = 0, "reduction is 0");
        CHECK_REFUSED(VolumeHeaderT, m.stored.reset(), "whether a reduction has no file is true");
    }

    TEST_CASE("a picture and a mesh on their way out") {
        CHECK_REFUSED(ExportPictureT, m.width = 0, "width is 0");
        CHECK_REFUSED(ExportPictureT, m.rgba.pop_back(), "size of rgba is 7, expected 8");
        CHECK_REFUSED(ExportPictureT, m.count = 2, "size of rgba is 8, expected 16");
        CHECK_REFUSED(ExportPictureT, m.delay_ms = 0, "delay_ms is 0");
        CHECK_REFUSED(ExportPictureT, m.marks[0]->points.clear(), "points of a mark is 0");
        CHECK_REFUSED(ExportPictureT, m.marks[0]->points[0].mutate_x(NAN), "x of a mark is nan");
        CHECK_REFUSED(ExportPictureT, m.marks[0]->align_x = 2, "align_x is 2");
        CHECK_REFUSED(ExportMeshT, m.surfaces.clear(), "number of surfaces is 0");
        CHECK_REFUSED(ExportMeshT, m.surfaces[0]->indices[0] = 3, "index 3 of 3 vertices");
        CHECK_REFUSED(ExportMeshT, m.keep = 1.5F, "keep is 1.5");
        CHECK_REFUSED(ExportMeshT, m.error_mm = -1, "error_mm is -1");
        CHECK_REFUSED(ExportMeshT, m.axes = static_cast<PatientAxes>(9), "axes is 9");
    }

    TEST_CASE("masks and measurements") {
        CHECK_REFUSED(MaskSurfaceT, m.slabs[0]->slab = 4095, "slab is 4095");
        CHECK_REFUSED(MeasureIsovaluesT, m.isovalues.clear(), "number of isovalues is 0");
        CHECK_REFUSED(MeasureIsovaluesT, m.isovalues[1] = 100, "isovalue 100 comes after 100");
        CHECK_REFUSED(MeasureIsovaluesT, m.isovalues[0] = nan_value, "isovalue is nan");
        CHECK_REFUSED(IsovaluesMeasuredT, m.slabs[0]->slab = 4095, "slab is 4095");
        CHECK_REFUSED(IsovaluesMeasuredT, m.slabs[0]->counts[1].mutate_area_mm2(nan_value),
                      "area_mm2 is nan");
    }

    TEST_CASE("a surface and its mesh") {
        CHECK_REFUSED(SetSurfaceT, m.isovalue = nan_value, "isovalue is nan");
        CHECK_REFUSED(SetSurfaceT, m.table = static_cast<CaseRule>(99), "table is 99");
        CHECK_REFUSED(SurfaceBuiltT, m.slabs[1].mutate_slab(0), "slab is 0, allowed are 1 .. 4094");
        CHECK_REFUSED(SurfaceBuiltT, m.slabs[1].mutate_slab(4095), "slab is 4095");
        CHECK_REFUSED(SurfaceBuiltT, m.slabs[0].mutate_area_mm2(nan_value), "area_mm2 is nan");
        CHECK_REFUSED(SurfaceBuiltT, m.left_out = 3, "left_out is 3, allowed are at most 2");
        CHECK_REFUSED(SurfaceBuiltT, m.gps_to_hold_all = 70'000, "gps_to_hold_all is 70000");
        CHECK_REFUSED(SurfaceBuiltT, m.slabs[1].mutate_cells_visited(21),
                      "cells_active is 22, allowed are at most 21");
        CHECK_REFUSED(SurfaceBuiltT, m.slabs[1].mutate_edges_crossed(71),
                      "edges_crossed is 71, allowed are at most 70");
        CHECK_REFUSED(FetchVoxelsT, m.box->mutate_z(4096), "z is 4096");
        CHECK_REFUSED(FetchVoxelsT, m.box->mutate_ny(0), "ny is 0");
        CHECK_REFUSED(FetchVoxelsT, m.box->mutate_nx(4096), "nx is 4096, allowed are 1 .. 4095");
        CHECK_REFUSED(VoxelValuesT, m.slices[1] = 3, "slice is 3, allowed are 4 ..");
        CHECK_REFUSED(VoxelValuesT, m.slices[1] = 4096, "slice is 4096");
        CHECK_REFUSED(VoxelValuesT, m.values.pop_back(), "bytes beyond whole slices is 1");
        CHECK_REFUSED(VoxelValuesT, m.slices.clear(), "bytes beyond whole slices is 8");
        CHECK_REFUSED(FetchMeshT, m.detail = 4, "detail is 4, allowed are at most 3");
        CHECK_REFUSED(FetchMeshT, m.origins = true, "origins of a simplified mesh is true");
        CHECK_REFUSED(MeshPartT, m.detail = 4, "detail is 4, allowed are at most 3");
        CHECK_REFUSED(MeshPartT, m.moved_mm = -0.5, "moved_mm is -0.5");
        CHECK_REFUSED(MeshPartT, m.slabs[0]->slab = 4095, "slab is 4095");
        CHECK_REFUSED(MeshPartT, m.slabs[0]->origins.push_back(m.slabs[0]->origins[0]),
                      "number of origins is 2, expected 1");
        CHECK_REFUSED(MeshPartT, m.slabs[0]->keys.pop_back(), "number of keys is 2, expected 3");
        CHECK_REFUSED(MeshPartT, m.slabs[0]->indices[1] = 3, "index 3 of 3 vertices");
        CHECK_REFUSED(MeshPartT, m.slabs[0]->indices.push_back(0), "whole triangles is 1");
        CHECK_REFUSED(MeshPartT, m.slabs[0]->vertices[2].mutate_nz(INFINITY),
                      "vertex 2 is not finite");
    }

    TEST_CASE("a scene") {
        CHECK_REFUSED(SceneBeginT, m.surfaces.assign(256, 0), "number of surfaces is 256");
        CHECK_REFUSED(SceneBeginT, m.surfaces[1] = 4, "different surfaces is 1, expected 2");
        CHECK_REFUSED(ScenePartT, m.slab = max_scene_slab + 1, "slab is 1048577");
        CHECK_REFUSED(ScenePartT, m.indices.pop_back(), "whole triangles is 2, expected 0");
        CHECK_REFUSED(ScenePartT, m.indices[2] = 3, "index 3 of 3 vertices");
        CHECK_REFUSED(ScenePartT, m.vertices[1].mutate_y(NAN), "a vertex's coordinate is nan");
        CHECK_REFUSED(ScenePartT, m.vertices[1].mutate_nx(1.5F), "a normal's component is 1.5");
        CHECK_REFUSED(ScenePartT, m.spheres[0].mutate_x(2e6F), "a sphere's coordinate is 2000000");
        CHECK_REFUSED(ScenePartT, m.spheres[0].mutate_radius(0), "a sphere's radius is 0");
        CHECK_REFUSED(ScenePartT, m.lines[0].mutate_bz(INFINITY), "a line's coordinate is inf");
    }

    TEST_CASE("an archive") {
        CHECK_REFUSED(ArchiveContentT, m.materials.clear(), "number of materials is 0");
        CHECK_REFUSED(ArchiveContentT, m.materials.resize(256), "number of materials is 256");
        CHECK_REFUSED(ArchiveContentT, m.low->mutate_y(5.5), "low is 5.5, allowed are at most 5");
        CHECK_REFUSED(ArchiveContentT, m.low->mutate_z(nan_value), "low is nan");
        CHECK_REFUSED(ArchiveContentT, m.high->mutate_x(INFINITY), "high is inf");
        CHECK_REFUSED(ArchiveContentT, m.structures = 65537, "structures is 65537");
        CHECK_REFUSED(ArchiveContentT, m.posted = 6, "posted is 6, allowed are 1 .. 5");
        CHECK_REFUSED(ArchiveContentT, m.specular = nan_value, "specular is nan");
        CHECK_REFUSED(ArchiveContentT, m.specular_power = 129, "specular_power is 129");
        CHECK_REFUSED(ArchiveContentT, m.notes.resize(17), "number of notes is 17");
        CHECK_REFUSED(ArchiveContentT, m.notes[0].resize(257), "length of a note is 257");
        CHECK_REFUSED(ArchiveContentT, m.parts.clear(), "number of primitives is 0");
        CHECK_REFUSED(ArchiveContentT, m.parts[1]->scene = 1, "scene of a part is 1, expected 0");
        CHECK_REFUSED(ArchiveContentT, m.parts[1]->slab = 0, "slab of a part is 0, expected 1");
        CHECK_REFUSED(ArchiveContentT, m.parts[1]->surface = 2, "material of a part is 2");
        CHECK_REFUSED(ArchiveContentT, m.parts[1]->indices[2] = 3, "index 3 of 3 vertices");
        CHECK_REFUSED(ArchiveContentT, m.parts[0]->spheres[0].mutate_radius(0),
                      "a sphere's radius is 0");
    }

    TEST_CASE("a request for a frame") {
        CHECK_REFUSED(DrawFrameT, m.frame = 0xffffffff,
                      "frame is 4294967295, allowed are at most 4294967294");
        CHECK_REFUSED(BeginFrameT, m.draw->frame = 0xffffffff, "frame is 4294967295");
        CHECK_REFUSED(DrawFrameT, m.width = 0, "width is 0, allowed are 1 .. 8192");
        CHECK_REFUSED(DrawFrameT, m.height = 8193, "height is 8193");
        CHECK_REFUSED(DrawFrameT, m.views.clear(), "number of views is 0, allowed are 1 .. 2");
        CHECK_REFUSED(DrawFrameT, m.lights.assign(5, m.lights[0]), "number of lights is 5");
        CHECK_REFUSED(DrawFrameT, m.lights[0].mutable_direction().mutate_z(2), "direction is 2");
        CHECK_REFUSED(DrawFrameT, m.lights[0].mutate_intensity(-1), "intensity is -1");
        CHECK_REFUSED(DrawFrameT, m.ambient = 1; m.lights.assign(2, m.lights[0]);
                      m.lights[0].mutate_intensity(1.5F);
                      m.lights[1].mutate_intensity(1.5F), "ambient light and all intensities is 4");
        CHECK_REFUSED(DrawFrameT, m.surfaces.resize(256, m.surfaces[0]), "surfaces is 256");
        CHECK_REFUSED(DrawFrameT, m.clip_planes.resize(17), "number of clip planes is 17");
        const std::string wrong = refusal_of<schema::DrawFrameT>([](auto& m) { planes(m, 3); });
        CHECK_MESSAGE(wrong.empty(), wrong);
        CHECK_REFUSED(DrawFrameT, planes(m, 4), "number of slice planes is 4");
        CHECK_REFUSED(DrawFrameT, (planes(m, 2), m.surfaces.resize(1)),
                      "number of slice planes is 2, allowed are 0 .. 1");
        CHECK_REFUSED(DrawFrameT, planes(m, 1, schema::SlicePlane(3, 0, 0, 1)), "axis is 3");
        CHECK_REFUSED(DrawFrameT, planes(m, 1, schema::SlicePlane(0, 4096, 0, 1)), "slice is 4096");
        CHECK_REFUSED(DrawFrameT, planes(m, 1, schema::SlicePlane(0, 0, 1, 1)),
                      "black is 1, must be below white, 1");
        CHECK_REFUSED(DrawFrameT, planes(m, 1, schema::SlicePlane(0, 0, NAN, 1)), "black is nan");
        CHECK_REFUSED(DrawFrameT, (planes(m, 1), m.surfaces[2].mutate_opacity(3)),
                      "opacity of a slice plane is 3, expected 16");
        CHECK_REFUSED(DrawFrameT, (planes(m, 1), m.surfaces[2].mutate_detail(1)),
                      "detail of a slice plane is 1, expected 0");
        CHECK_REFUSED(DrawFrameT, m.clip_planes[0] = schema::ClipPlane(0, 0, INFINITY, 0),
                      "clip plane is inf");
        CHECK_REFUSED(DrawFrameT, m.surfaces[0].mutate_opacity(17), "opacity is 17");
        CHECK_REFUSED(DrawFrameT, m.surfaces[0].mutate_rim(17), "rim is 17");
        CHECK_REFUSED(DrawFrameT, (planes(m, 1), m.surfaces[2].mutate_rim(3)),
                      "rim of a slice plane is 3, expected 0");
        CHECK_REFUSED(DrawFrameT, m.surfaces[0].mutate_detail(4),
                      "detail is 4, allowed are at most 3");
        CHECK_REFUSED(DrawFrameT, m.surfaces[0].mutate_slabs(static_cast<SlabChoice>(9)),
                      "slabs is 9");
        CHECK_REFUSED(DrawFrameT, m.specular_power = 129, "specular_power is 129");
        CHECK_REFUSED(DrawFrameT, m.ambient = NAN, "ambient is nan");
        CHECK_REFUSED(DrawFrameT, m.specular = 1.5F, "specular is 1.5");
        CHECK_REFUSED(DrawFrameT, m.views[0]->projection->mutable_m()->Mutate(3, nan_value),
                      "projection holds nan");
        CHECK_REFUSED(DrawFrameT, m.samples = 8, "samples is 8, allowed are 1, 4, 16");
        CHECK_REFUSED(DrawFrameT, m.sample = 1, "sample is 1, allowed are 0 .. 0");
        CHECK_REFUSED(DrawFrameT, (m.samples = 4, m.sample = 3), "read_depths is true");
        CHECK_REFUSED(DrawFrameT, (m.samples = 4, m.sample = 2, m.read_depths = false),
                      "read_back before the last sample is true");
        CHECK_REFUSED(BeginFrameT, m.assignment.pop_back(), "size of assignment is 5, expected 6");
        CHECK_REFUSED(BeginFrameT, m.assignment[2] = 256, "assigned Renderer is 256");
        CHECK_REFUSED(BeginFrameT, m.draw->width = 0, "width is 0");
    }

    TEST_CASE("programs, pixels and finished frames") {
        CHECK_REFUSED(RegionProgramsT, m.gp = 256, "gp is 256");
        CHECK_REFUSED(RegionProgramsT, m.moved_mm = NAN, "moved_mm is nan");
        CHECK_REFUSED(RegionProgramsT, m.regions[0]->region = 8192, "region is 8192");
        CHECK_REFUSED(RegionProgramsT, m.regions[0]->segments[1].mutate_word_count(3),
                      "region 5: segment of slab 3 ends at word 5 of 4");
        CHECK_REFUSED(RegionProgramsT,
                      m.regions[0]->segments[0] = schema::Segment(0, 0, 0xffffffff, 0xffffffff),
                      "ends at word 8589934590 of 4");
        CHECK_REFUSED(RegionPixelsT, m.moved_mm = INFINITY, "moved_mm is inf");
        CHECK_REFUSED(RegionPixelsT, m.renderer = 256, "renderer is 256");
        CHECK_REFUSED(RegionPixelsT, m.pixels.pop_back(), "is 16383, expected 16384");
        CHECK_REFUSED(RegionPixelsT, m.tiles[0].mutate_region(9000), "region is 9000");
        CHECK_REFUSED(RegionPixelsT, m.tiles[0].mutate_has_depths(false),
                      "number of depths is 16384, expected 0");
        CHECK_REFUSED(RegionPixelsT, m.depths.clear(), "number of depths is 0, expected 16384");
        CHECK_REFUSED(RegionPixelsT, m.depths.pop_back(),
                      "number of depths is 16383, expected 16384");
        CHECK_REFUSED(FrameDoneT, m.moved_mm = INFINITY, "moved_mm is inf");
        CHECK_REFUSED(FrameDoneT, m.views = 3, "views is 3");
        CHECK_REFUSED(FrameDoneT, m.pixels.pop_back(), "number of pixels is 7, expected 8");
        CHECK_REFUSED(FrameDoneT, m.region_cycles.clear(), "region_cycles is 0, expected 1");
        CHECK_REFUSED(FrameDoneT, m.region_renderers.clear(), "region_renderers is 0, expected 1");
        CHECK_REFUSED(FrameDoneT, m.region_renderers[0] = 256, "a region's Renderer is 256");
    }

    TEST_CASE("the counts of a frame") {
        CHECK_REFUSED(FrameCountsT, m.drawn[1].mutate_surface(255), "surface is 255");
        CHECK_REFUSED(FrameCountsT, m.drawn[0].mutate_slab(max_scene_slab + 1), "slab is 1048577");
        CHECK_REFUSED(FrameCountsT, m.drawn[1].mutate_culled(51),
                      "culled is 51, allowed are at most 50");
        CHECK_REFUSED(FrameCountsT, m.drawn[1] = m.drawn[0],
                      "surface 0, slab 7 comes after surface 0, slab 7");
        CHECK_REFUSED(FrameCountsT, m.parts[0].mutate_region(8192), "region is 8192");
        CHECK_REFUSED(FrameCountsT, m.parts[0].mutate_region(6), "region is 5, allowed are 6 ..");
        CHECK_REFUSED(FrameCountsT, m.parts[0].mutate_kind(static_cast<PartKind>(6)), "kind is 6");
        CHECK_REFUSED(FrameCountsT, m.parts[0].mutate_surface(255), "surface is 255");
        CHECK_REFUSED(FrameCountsT, m.parts[0].mutate_slab(max_scene_slab + 1), "slab is 1048577");
        CHECK_REFUSED(FrameCountsT, m.parts[0].mutate_primitives(41),
                      "primitives is 41, allowed are at most 40");
        // All classes take 150 cycles.
        CHECK_REFUSED(FrameCountsT, m.parts[1].mutate_port_cycles(151),
                      "port_cycles is 151, allowed are at most 150");
        CHECK_REFUSED(FrameCountsT, m.parts[1].mutate_backing_cycles(51),
                      "backing_cycles beside the port's is 51, allowed are at most 50");
    }

    TEST_CASE("the activity of a node") {
        CHECK_REFUSED(ActivityT, m.wall_ns = 599, "time of a stage beside the others is 600");
        CHECK_REFUSED(ActivityT, m.stages[0]->name = std::string(33, 'x'),
                      "length of a stage's name is 33, allowed are at most 32");
        CHECK_REFUSED(ActivityT, m.sent[0].mutate_kind(0), "kind is 0");
        CHECK_REFUSED(ActivityT, m.sent[0].mutate_kind(999), "kind is 999");
        CHECK_REFUSED(ActivityT, m.sent[0].mutate_channel(64), "channel is 64");
        CHECK_REFUSED(
            ActivityT,
            for (int i = 0; i < 16; ++i) {
                m.stages.push_back(std::make_unique<schema::StageTimeT>(*m.stages[0]));
                m.stages.back()->ns = 0;
            },
            "number of stages is 17, allowed are at most 16");
    }

    TEST_CASE("regions are counted over both views") {
        CHECK(region_count(128, 128, 1) == 1);
        CHECK(region_count(129, 128, 1) == 2);
        CHECK(region_count(1280, 1024, 1) == 80);
        CHECK(region_count(640, 512, 2) == 40);
        CHECK(max_regions == 8192);
    }

    TEST_CASE("lists that share their elements are refused before all are checked") {
        constexpr std::size_t vertex_count = 1000, repeated = 100'000;
        flatbuffers::FlatBufferBuilder builder;
        const auto vertices = builder.CreateVectorOfStructs(
            std::vector<schema::MeshVertex>(vertex_count, schema::MeshVertex(0, 0, 0, 0, 0, 1)));
        const auto indices = builder.CreateVector(std::vector<std::uint32_t>{0, 1, 2});
        const auto keys = builder.CreateVector(std::vector<std::uint64_t>(vertex_count));
        const auto slab = schema::CreateSlabMesh(builder, 0, vertices, keys, indices);
        const auto slabs = builder.CreateVector(
            std::vector<flatbuffers::Offset<schema::SlabMesh>>(repeated, slab));
        const Payload part = finish(builder, schema::CreateMeshPart(builder, 1, 1, slabs));
        CHECK(contains(refusal(part), "its lists have more elements than its"));
    }

    TEST_CASE("curves and findings that share their contents are refused") {
        constexpr std::size_t shared = 100'000;
        flatbuffers::FlatBufferBuilder curves;
        const auto counts = curves.CreateVectorOfStructs(
            std::vector<schema::IsovalueCounts>(shared, schema::IsovalueCounts(1, 1, 1)));
        std::vector<flatbuffers::Offset<schema::SlabCurve>> slabs;
        for (std::uint32_t slab = 0; slab < 100; ++slab) {
            slabs.push_back(schema::CreateSlabCurve(curves, slab, counts));
        }
        CHECK(contains(refusal(finish(curves, schema::CreateIsovaluesMeasured(
                                                  curves, curves.CreateVector(slabs)))),
                       "its lists have more elements than its"));

        const schema::VolumeHeaderT sound = example_header();
        flatbuffers::FlatBufferBuilder builder;
        const auto name = builder.CreateString(sound.name);
        const auto text = builder.CreateString(std::string(shared, 'x'));
        const auto finding = schema::CreateFinding(builder, FindingKind::note, text);
        const auto findings =
            builder.CreateVector(std::vector<flatbuffers::Offset<schema::Finding>>(100, finding));
        schema::VolumeHeaderBuilder header(builder);
        header.add_name(name);
        header.add_nx(sound.nx);
        header.add_ny(sound.ny);
        header.add_nz(sound.nz);
        header.add_voxel_to_patient(sound.voxel_to_patient.get());
        header.add_findings(findings);
        CHECK(contains(refusal(finish(builder, header.Finish())),
                       "its lists have more elements than its"));
    }
}
