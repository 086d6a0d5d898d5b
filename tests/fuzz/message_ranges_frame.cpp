#include "ringbus/channel_model.hpp"
#include "tests/fuzz/documented.hpp"
#include "tests/fuzz/message_ranges.hpp"

namespace pxpl5::fuzz {

namespace {

using namespace bus::schema;

void check(const DrawFrame& draw) {
    require(draw.frame() != 0xffffffff, "frame");
    in("width", draw.width(), 1, max_picture_px);
    in("height", draw.height(), 1, max_picture_px);
    in("views", draw.views()->size(), 1, max_views);
    in("lights", draw.lights()->size(), 0, max_lights);
    in("surfaces", draw.surfaces()->size(), 0, max_surfaces);
    in("clip_planes", length(draw.clip_planes()), 0, max_clip_planes);
    in("ambient", draw.ambient(), 0, 1);
    in("specular", draw.specular(), 0, 1);
    in("specular_power", draw.specular_power(), 1, max_specular_power);
    each(draw.views(), [](const View& view) {
        finite("voxel_to_eye", *view.voxel_to_eye());
        finite("projection", *view.projection());
    });
    for (const Light* light : *draw.lights()) {
        const Vec3& d = light->direction();
        in("unit length", std::hypot(double{d.x()}, double{d.y()}, double{d.z()}), 0.998, 1.002);
        finite("intensity", light->intensity());
    }
    each(draw.surfaces(), [](const SurfaceDraw& surface) {
        known("slabs", surface.slabs());
        in("opacity", surface.opacity(), 1, full_opacity);
        in("detail", surface.detail(), 0, max_detail);
        in("rim", surface.rim(), 0, max_rim);
    });
    in("slice planes", length(draw.planes()), 0, max_slice_planes);
    in("slice planes", length(draw.planes()), 0, draw.surfaces()->size());
    each(draw.planes(), [](const SlicePlane& plane) {
        in("axis", plane.axis(), 0, 2);
        in("slice", plane.index(), 0, max_volume_voxels - 1);
        finite("gray values", plane.black(), plane.white());
        require(plane.black() < plane.white(), "black below white");
    });
    each(draw.clip_planes(),
         [](const ClipPlane& p) { finite("clip plane", p.a(), p.b(), p.c(), p.d()); });
    const int samples = draw.samples();
    require(samples == 1 || samples == few_samples || samples == many_samples, "samples");
    in("sample", draw.sample(), 0, samples - 1);
}

void check(const BeginFrame& begin) {
    const DrawFrame& draw = *begin.draw();
    check(draw);
    require(
        begin.assignment()->size() == regions_of(draw.width(), draw.height(), draw.views()->size()),
        "assignment");
    for (const std::uint16_t renderer : *begin.assignment()) {
        in("assigned Renderer", renderer, 0, max_nodes - 1);
    }
}

constexpr int most_regions = 8192;  // Two views of 8192 x 8192 pixels.

void check(const RegionPrograms& programs) {
    in("gp", programs.gp(), 0, max_nodes - 1);
    require(std::isfinite(programs.moved_mm()) && programs.moved_mm() >= 0, "moved_mm");
    each(programs.regions(), [](const RegionProgram& region) {
        in("region", region.region(), 0, most_regions - 1);
        for (const Segment* segment : *region.segments()) {
            in("end of a segment", std::uint64_t{segment->first_word()} + segment->word_count(), 0,
               region.words()->size());
        }
        in("origins", length(region.origins()), 0, region.words()->size());
    });
}

void check(const RegionPixels& pixels) {
    const std::size_t all = pixels.tiles()->size() * region_pixels;
    in("renderer", pixels.renderer(), 0, max_nodes - 1);
    require(std::isfinite(pixels.moved_mm()) && pixels.moved_mm() >= 0, "moved_mm");
    require(pixels.pixels()->size() == 0 || pixels.pixels()->size() == all, "pixels");
    std::size_t depths = 0;
    for (const RegionTile* tile : *pixels.tiles()) {
        in("region", tile->region(), 0, most_regions - 1);
        depths += tile->has_depths() ? region_pixels : 0;
    }
    require(length(pixels.depths()) == depths, "depths");
}

void check(const FrameDone& done) {
    in("width", done.width(), 1, max_picture_px);
    in("height", done.height(), 1, max_picture_px);
    in("views", done.views(), 1, max_views);
    require(std::isfinite(done.moved_mm()) && done.moved_mm() >= 0, "moved_mm");
    const std::uint64_t regions = regions_of(done.width(), done.height(), done.views());
    require(done.region_cycles()->size() == regions, "region_cycles");
    require(done.region_renderers()->size() == regions, "region_renderers");
    for (const std::uint16_t renderer : *done.region_renderers()) {
        in("a region's Renderer", renderer, 0, max_nodes - 1);
    }
    const std::uint64_t all = std::uint64_t{done.width()} * done.height() * done.views();
    require(done.pixels() == nullptr || done.pixels()->size() == all, "pixels");
    require(done.depths() == nullptr || done.depths()->size() == all, "depths");
}

void check(const Activity& activity) {
    std::uint64_t left_ns = activity.wall_ns();
    each(activity.stages(), [&](const StageTime& stage) {
        in("time of a stage", stage.ns(), 0, left_ns);
        left_ns -= stage.ns();
    });
    for (const SentCount* sent : *activity.sent()) {
        in("kind", sent->kind(), 1, static_cast<int>(Body::MAX));
        in("channel", sent->channel(), 0, bus::max_channels - 1);
    }
}

void check(const PartCounts& part) {
    in("region", part.region(), 0, most_regions - 1);
    known("kind of part", part.kind());
    in("surface", part.surface(), 0, max_surfaces - 1);
    in("slab", part.slab(), 0, max_scene_slab);
    in("primitives", part.primitives(), 0, part.words());
}

void check(const FrameCounts& counts) {
    std::pair<std::int64_t, std::int64_t> last(-1, -1);
    for (const DrawnSlab* slab : *counts.drawn()) {
        in("surface", slab->surface(), 0, max_surfaces - 1);
        in("slab", slab->slab(), 0, max_scene_slab);
        in("culled", slab->culled(), 0, slab->primitives());
        const std::pair<std::int64_t, std::int64_t> at(slab->surface(), slab->slab());
        require(last < at, "order of drawn slabs");
        last = at;
    }
    std::uint16_t region = 0;
    for (const PartCounts* part : *counts.parts()) {
        check(*part);
        require(part->region() >= region, "order of parts");
        region = part->region();
    }
}

/// Checks the body if it is one of these tables.
template <typename... Tables>
void check_frame_of(const bus::Message& message) {
    (if_kind<Tables>(message, [](const Tables& body) { check(body); }), ...);
}

}  // namespace

void require_documented_frame(const bus::Message& message) {
    check_frame_of<DrawFrame, BeginFrame, RegionPrograms, RegionPixels, FrameDone, Activity,
                   FrameCounts>(message);
}

}  // namespace pxpl5::fuzz
