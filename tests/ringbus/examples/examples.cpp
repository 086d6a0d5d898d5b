#include "tests/ringbus/examples/examples.hpp"

#include <algorithm>
#include <array>

#include "generated/vocabulary.hpp"
#include "tests/ringbus/examples/volume_examples.hpp"

namespace pxpl5::test {

namespace schema = bus::schema;
using bus::pack;
using bus::Payload;

namespace {

std::vector<Payload> control_examples() {
    schema::HelloT hello;
    hello.role = schema::Role::renderer;
    hello.index = 3;
    hello.pid = 4711;
    hello.endpoint = "ipc:///run/renderer-3";
    hello.build = "pxpl5 0.1.0";
    hello.schema_hash = 0x123456789abcdef0;
    schema::TopologyT topology;
    for (std::uint16_t id = 0; id < 3; ++id) {
        auto node = std::make_unique<schema::NodeInfoT>();
        node->id = id;
        node->role = static_cast<schema::Role>(id);
        node->endpoint = "tcp://127.0.0.1:4000" + std::to_string(id);
        topology.nodes.push_back(std::move(node));
    }
    topology.gp_memory_bytes = 8 << 20;
    topology.ring_bytes_per_s = 80'000'000;
    topology.ring_hop_ns = 50;
    topology.recording = Recording::flight;
    schema::ShutdownT shutdown;
    shutdown.reason = "the user said quit";
    schema::CreditT credit;
    credit.messages = 256;
    credit.bytes = 123'456'789'012;
    schema::FaultT fault;
    fault.code = schema::FaultCode::lost_message;
    fault.node = 5;
    fault.source = 2;
    fault.sequence = 77;
    fault.reason = "message 77 is missing";
    fault.frame = 12;
    fault.request = static_cast<std::uint16_t>(schema::Body::BeginFrame);
    schema::TraceSavedT saved;
    saved.messages = 12;
    saved.bytes = 34'567;
    saved.error = "no space left on device";
    return {pack(hello),
            pack(topology),
            pack(schema::ConnectedT{}),
            pack(schema::GoT{}),
            pack(shutdown),
            pack(credit),
            pack(fault),
            pack(schema::SaveTraceT{}),
            pack(saved)};
}

std::vector<Payload> surface_examples() {
    schema::SetSurfaceT set;
    set.surface = 2;
    set.revision = 8;
    set.isovalue = 300.5;
    set.table = CaseRule::lorensen1987;
    schema::RemoveSurfaceT remove;
    remove.surface = 2;
    schema::SurfaceBuiltT built;
    built.surface = 2;
    built.revision = 8;
    built.slabs = {schema::SlabCounts(0, 10, 11, 12, 1, 2, 30, 60, 15, 3.5, -4.5),
                   schema::SlabCounts(5, 20, 21, 22, 2, 3, 40, 70, 25, 4.5, 5.5)};
    built.memory_bytes = 1234;
    built.elapsed_us = 5678;
    built.left_out = 1;
    built.gps_to_hold_all = 3;
    schema::FetchMeshT fetch;
    fetch.surface = 2;
    fetch.detail = 1;
    schema::MeshPartT part;
    part.surface = 2;
    part.revision = 8;
    part.detail = 1;
    part.moved_mm = 1.25;
    auto slab = std::make_unique<schema::SlabMeshT>();
    slab->slab = 5;
    slab->vertices.assign(3, schema::MeshVertex(1, 2, 3, 0, 0, 1));
    slab->keys = {4, 8, 13};
    slab->indices = {0, 1, 2};
    slab->origins = {schema::Origin(1, 2, 3, 0, 0, 0)};
    part.slabs.push_back(std::move(slab));
    schema::MaskSurfaceT mask;
    mask.surface = 2;
    mask.revision = 8;
    mask.slabs.push_back(std::make_unique<schema::SlabMaskT>());
    mask.slabs[0]->slab = 5;
    mask.slabs[0]->hidden = {1};
    schema::MeasureIsovaluesT measure;
    measure.isovalues = {100, 200.5};
    schema::IsovaluesMeasuredT measured;
    measured.slabs.push_back(std::make_unique<schema::SlabCurveT>());
    measured.slabs[0]->slab = 5;
    measured.slabs[0]->counts = {schema::IsovalueCounts(1, 2, 3), schema::IsovalueCounts(4, 5, 6)};
    return {pack(set),  pack(remove), pack(built),   pack(fetch),
            pack(part), pack(mask),   pack(measure), pack(measured)};
}

std::vector<Payload> frame_examples() {
    schema::BeginFrameT begin;
    begin.draw = std::make_unique<schema::DrawFrameT>(example_draw());
    begin.assignment = {0, 1, 0, 1, 0, 1};  // 300 x 200 pixels: 3 x 2 regions.
    schema::RegionPixelsT pixels;
    pixels.frame = 4;
    pixels.renderer = 1;
    pixels.moved_mm = 1.25;
    pixels.tiles = {schema::RegionTile(3, true, 20'000, 1500)};
    pixels.pixels.assign(region_pixels, 0xff336699);
    pixels.depths.assign(region_pixels, 0xffffff00);
    schema::FrameDoneT done;
    done.frame = 4;
    done.width = 4;
    done.height = 2;
    done.views = 1;
    done.moved_mm = 1.25;
    done.region_cycles = {12'345};
    done.region_renderers = {1};
    done.instructions = 678;
    done.pixels = {1, 2, 3, 4, 5, 6, 7, 8};
    done.depths = {8, 7, 6, 5, 4, 3, 2, 1};
    return {pack(example_draw()), pack(begin), pack(example_programs()), pack(pixels), pack(done)};
}

schema::ArchiveContentT example_archive(const schema::ScenePartT& part) {
    schema::ArchiveContentT content;
    content.materials = {schema::SceneMaterial(schema::Rgb(1, 2, 3), true),
                         schema::SceneMaterial(schema::Rgb(4, 5, 6), false)};
    for (std::uint32_t slab = 0; slab < 2; ++slab) {
        content.parts.push_back(std::make_unique<schema::ScenePartT>(part));
        content.parts.back()->scene = 0;
        content.parts.back()->surface = static_cast<std::uint16_t>(slab);
        content.parts.back()->slab = slab;
    }
    content.low = std::make_unique<schema::ScenePoint>(1, 2, 3);
    content.high = std::make_unique<schema::ScenePoint>(4, 5, 6);
    content.structures = 5;
    content.posted = 2;
    content.polygons = 1;
    content.specular = 0.25;
    content.specular_power = 40;
    content.notes = {"translucent colors, drawn opaque: 2"};
    return content;
}

std::vector<Payload> scene_examples() {
    schema::SceneBeginT begin;
    begin.scene = 3;
    begin.surfaces = {4, 7};
    schema::ScenePartT part;
    part.scene = 3;
    part.surface = 7;
    part.slab = 5;
    part.vertices.assign(3, schema::MeshVertex(1, 2, 3, 0, 0, 1));
    part.indices = {0, 1, 2};
    part.spheres = {schema::SceneSphere(1, 2, 3, 0.5F)};
    part.lines = {schema::SceneLine(1, 2, 3, 4, 5, 6)};
    schema::SceneEndT end;
    end.scene = 3;
    schema::ReadArchiveT read;
    read.path = "room.phigs";
    return {pack(begin), pack(part), pack(end), pack(read), pack(example_archive(part))};
}

std::vector<Payload> activity_examples() {
    schema::ActivityT activity;
    activity.wall_ns = 1000;
    activity.cpu_ns = 700;
    activity.stages.push_back(std::make_unique<schema::StageTimeT>());
    activity.stages[0]->name = "extract";
    activity.stages[0]->ns = 600;
    activity.stages[0]->count = 3;
    activity.sent = {
        schema::SentCount(7, static_cast<std::uint16_t>(schema::Body::RegionPrograms), 5, 2, 900)};
    activity.received_messages = 4;
    activity.received_bytes = 500;
    activity.memory_bytes = 1 << 20;
    activity.queue = 1;
    activity.held_up = 2;
    activity.frames = 9;
    return {pack(schema::AskActivityT{}), pack(activity)};
}

schema::PartCounts example_part(std::uint16_t region, PartKind kind) {
    std::array<schema::ClassCounts, 6> classes{};
    for (std::uint64_t i = 0; i < classes.size(); ++i) {
        classes.at(i) = schema::ClassCounts(i, 10 * i);
    }
    return {region, 1, kind, 7, 2, 40, 100, 50, flatbuffers::make_span(classes)};
}

std::vector<Payload> counts_examples() {
    schema::FrameCountsT counts;
    counts.frame = 4;
    counts.drawn = {schema::DrawnSlab(0, 7, 100, 40), schema::DrawnSlab(1, 3, 50, 50)};
    counts.words = 2400;
    counts.parts = {example_part(3, PartKind::segment), example_part(5, PartKind::end_of_region)};
    return {pack(counts)};
}

/// Unpacks and packs table T if that is the message's kind.
template <typename T>
void repack_if(const bus::Message& message, Payload& result) {
    if (const T* body = message.as<T>()) {
        typename T::NativeTableType object;
        body->UnPackTo(&object);
        result = pack(object);
    }
}

template <typename... Ts>
Payload repacked_as_one_of(const bus::Message& message) {
    Payload result;
    (repack_if<Ts>(message, result), ...);
    return result;
}

}  // namespace

schema::Matrix identity() {
    std::array<double, 16> m{};
    for (std::size_t i = 0; i < 16; i += 5) {
        m[i] = 1;
    }
    return schema::Matrix(flatbuffers::make_span(m));
}

schema::DrawFrameT example_draw() {
    schema::DrawFrameT draw;
    draw.frame = 4;
    draw.width = 300;
    draw.height = 200;
    auto view = std::make_unique<schema::ViewT>();
    view->voxel_to_eye = std::make_unique<schema::Matrix>(identity());
    view->projection = std::make_unique<schema::Matrix>(identity());
    draw.views.push_back(std::move(view));
    draw.lights.push_back(schema::Light(schema::Vec3(0, 0, 1), 0.8F));
    draw.ambient = 0.25F;
    draw.specular = 0.5F;
    draw.specular_power = 20;
    draw.background = std::make_unique<schema::Rgb>(1, 2, 3);
    draw.surfaces.push_back(schema::SurfaceDraw(1, 2, schema::Rgb(9, 8, 7), true,
                                                SlabChoice::outside_gaps, full_opacity, 2, 5));
    draw.clip_planes.push_back(schema::ClipPlane(1, 0, 0, -5));
    draw.surfaces.push_back(schema::SurfaceDraw(plane_surface_id, 0, schema::Rgb(), false,
                                                SlabChoice::all, full_opacity, 0, 0));
    draw.planes.push_back(schema::SlicePlane(2, 5, -160, 240));
    draw.read_back = true;
    draw.read_depths = true;
    draw.region_costs = {5, 4, 3, 2, 1, 0};
    draw.counts = true;
    return draw;
}

schema::RegionProgramsT example_programs() {
    schema::RegionProgramsT programs;
    programs.frame = 4;
    programs.gp = 1;
    auto region = std::make_unique<schema::RegionProgramT>();
    region->region = 5;
    region->words = {1, 2, 3, 4};
    region->segments = {schema::Segment(0, 7, 0, 2), schema::Segment(1, 3, 2, 2)};
    programs.regions.push_back(std::move(region));
    programs.moved_mm = 1.25;
    programs.triangles_in = 100;
    programs.triangles_out = 60;
    return programs;
}

std::vector<Payload> one_of_each_kind() {
    std::vector<Payload> all;
    for (const auto& group :
         {control_examples(), volume_examples(), surface_examples(), frame_examples(),
          scene_examples(), activity_examples(), counts_examples()}) {
        all.insert(all.end(), group.begin(), group.end());
    }
    std::ranges::sort(all, {}, &Payload::kind);  // As the union has them.
    return all;
}

Payload repacked(const bus::Message& message) {
    using namespace bus::schema;
    return repacked_as_one_of<
        Hello, Topology, Connected, Go, Shutdown, Credit, Fault, ImportVolume, VolumeHeader, Slices,
        VolumeEnd, VolumeReady, ExportPicture, IoDone, SetSurface, RemoveSurface, SurfaceBuilt,
        FetchMesh, MeshPart, DrawFrame, BeginFrame, RegionPrograms, RegionPixels, FrameDone,
        SaveTrace, TraceSaved, SceneBegin, ScenePart, SceneEnd, DropVolume, MaskSurface,
        MeasureIsovalues, IsovaluesMeasured, ExportMesh, AskActivity, Activity, FrameCounts,
        ReadMesh, MeshContent, ReadArchive, ArchiveContent, FetchVoxels, VoxelValues>(message);
}

}  // namespace pxpl5::test
