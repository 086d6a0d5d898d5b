#include "ringbus/ranges.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "ringbus/activity.hpp"
#include "ringbus/channel_model.hpp"
#include "ringbus/range_check.hpp"
#include "ringbus/rules/light_sum.hpp"
#include "ringbus/rules/regions.hpp"
#include "ringbus/rules/slice_planes.hpp"
#include "ringbus/rules/slices_file.hpp"

namespace pxpl5::bus {

namespace {

std::string range_of(const schema::Hello& hello) {
    return Check().known("role", hello.role()).reason();
}

std::string range_of(const schema::Topology& topology) {
    Check check;
    check.within("number of nodes", topology.nodes()->size(), 1, max_nodes)
        .within("ring channels", topology.ring_channels(), 1, max_channels);
    std::set<NodeId> seen;
    for (const auto* node : *topology.nodes()) {
        check.known("role", node->role());
        if (!seen.insert(node->id()).second) {
            check.add(fmt::format("node {} is there twice", node->id()));
        }
    }
    check.known("recording", topology.recording());
    return check.reason();
}

std::string range_of(const schema::Fault& fault) {
    return Check()
        .known("code", fault.code())
        .at_most("request", fault.request(), static_cast<std::size_t>(Body::MAX))
        .reason();
}

/// Checks a frame that is one pass of a picture. Only the last pass is read back. No pass has
/// depths, because depths have no mean.
std::string pass_range(const schema::DrawFrame& draw) {
    const int sample = draw.sample(), samples = draw.samples();
    if (std::ranges::find(sample_counts, samples) == sample_counts.end()) {
        return fmt::format("samples is {}, allowed are {}", samples,
                           fmt::join(sample_counts, ", "));
    }
    Check check;
    check.within("sample", sample, 0, samples - 1);
    if (samples > 1) {
        check.equal("read_depths", draw.read_depths(), false);
        if (sample + 1 < samples) {
            check.equal("read_back before the last sample", draw.read_back(), false);
        }
    }
    return check.reason();
}

std::string planes_range(const schema::DrawFrame& draw) {
    const std::size_t most = std::min<std::size_t>(max_slice_planes, draw.surfaces()->size());
    Check check;
    check.within("number of slice planes", plane_count(draw), std::size_t{0}, most);
    for (std::size_t k = 0; k < plane_count(draw); ++k) {
        const auto* plane = draw.planes()->Get(static_cast<flatbuffers::uoffset_t>(k));
        check.at_most("axis", plane->axis(), 2)
            .at_most("slice", plane->index(), max_volume_voxels - 1)
            .within("black", plane->black(), -2 * most_window, 2 * most_window)
            .within("white", plane->white(), -2 * most_window, 2 * most_window);
        if (!(plane->black() < plane->white())) {
            check.add(fmt::format("black is {}, must be below white, {}", plane->black(),
                                  plane->white()));
        }
    }
    for (std::size_t i = draw.surfaces()->size() - std::min(plane_count(draw), most);
         i < draw.surfaces()->size(); ++i) {
        const auto* entry = draw.surfaces()->Get(static_cast<flatbuffers::uoffset_t>(i));
        check
            .equal("slabs of a slice plane", static_cast<int>(entry->slabs()),
                   static_cast<int>(SlabChoice::all))
            .equal("opacity of a slice plane", int{entry->opacity()}, full_opacity)
            .equal("detail of a slice plane", int{entry->detail()}, 0)
            .equal("rim of a slice plane", int{entry->rim()}, 0);
    }
    return check.reason();
}

/// The next frame has a number, too.
constexpr std::uint32_t last_frame = 0xfffffffe;

std::string range_of(const schema::DrawFrame& draw) {
    Check check;
    check.at_most("frame", draw.frame(), last_frame);
    check.add(pass_range(draw));
    check.within("width", draw.width(), 1, max_picture_px)
        .within("height", draw.height(), 1, max_picture_px)
        .within("number of views", draw.views()->size(), 1, max_views)
        .within("number of lights", draw.lights()->size(), 0, max_lights)
        .within("number of surfaces", draw.surfaces()->size(), 0, max_surfaces)
        .within("number of clip planes", size_of(draw.clip_planes()), 0, max_clip_planes)
        .within("specular_power", draw.specular_power(), 1, max_specular_power)
        .within("ambient", draw.ambient(), 0.0F, 1.0F)
        .within("specular", draw.specular(), 0.0F, 1.0F);
    for (const auto* view : *draw.views()) {
        check.finite("voxel_to_eye", *view->voxel_to_eye())
            .finite("projection", *view->projection());
    }
    double sum = draw.ambient();
    for (const auto* light : *draw.lights()) {
        const schema::Vec3& d = light->direction();
        const float length = std::sqrt(d.x() * d.x() + d.y() * d.y() + d.z() * d.z());
        check.within("length of a light's direction", length, 0.999F, 1.001F)
            .within("intensity", light->intensity(), 0.0F, max_light_sum);
        sum += light->intensity();
    }
    check.within("ambient light and all intensities", sum, 0.0, double{max_light_sum});
    for (std::size_t i = 0; i < size_of(draw.clip_planes()); ++i) {
        const auto* plane = draw.clip_planes()->Get(static_cast<flatbuffers::uoffset_t>(i));
        check.finite("clip plane", plane->a()).finite("clip plane", plane->b());
        check.finite("clip plane", plane->c()).finite("clip plane", plane->d());
    }
    for (const auto* surface : *draw.surfaces()) {
        check.known("slabs", surface->slabs())
            .within("opacity", surface->opacity(), 1, full_opacity)
            .at_most("detail", surface->detail(), max_detail)
            .at_most("rim", surface->rim(), max_rim);
    }
    check.add(planes_range(draw));
    return check.reason();
}

std::string range_of(const schema::BeginFrame& begin) {
    const schema::DrawFrame& draw = *begin.draw();
    Check check;
    check.add(range_of(draw))
        .equal("size of assignment", std::size_t{begin.assignment()->size()},
               region_count(draw.width(), draw.height(), draw.views()->size()));
    for (const std::uint16_t renderer : *begin.assignment()) {
        check.at_most("assigned Renderer", renderer, max_nodes - 1);
    }
    return check.reason();
}

/// The order of segments is left to the Renderer, which can leave one out and finish the frame.
std::string range_of(const schema::RegionProgram& program) {
    const std::uint64_t words = program.words()->size();
    for (const auto* segment : *program.segments()) {
        const std::uint64_t end = std::uint64_t{segment->first_word()} + segment->word_count();
        if (end > words) {
            return fmt::format("region {}: segment of slab {} ends at word {} of {}",
                               program.region(), segment->slab(), end, words);
        }
    }
    // Each primitive has one word at least.
    return Check().at_most("number of origins", size_of(program.origins()), words).reason();
}

std::string range_of(const schema::RegionPrograms& programs, Elements elements) {
    Check check;
    check.at_most("gp", programs.gp(), max_nodes - 1).length("moved_mm", programs.moved_mm());
    for (const auto* region : *programs.regions()) {
        if (!elements.take(check, region->segments()->size())) {
            break;
        }
        check.at_most("region", region->region(), max_regions - 1);
        check.add(range_of(*region));
    }
    return check.reason();
}

std::string range_of(const schema::RegionPixels& pixels) {
    const std::size_t wanted = std::size_t{pixels.tiles()->size()} * region_pixels;
    Check check;
    check.at_most("renderer", pixels.renderer(), max_nodes - 1)
        .length("moved_mm", pixels.moved_mm())
        .equal("number of pixels", std::size_t{pixels.pixels()->size()},
               pixels.pixels()->size() == 0 ? 0 : wanted);
    std::size_t with_depths = 0;
    for (const auto* tile : *pixels.tiles()) {
        check.at_most("region", tile->region(), max_regions - 1);
        with_depths += tile->has_depths() ? 1 : 0;
    }
    const std::size_t depths = pixels.depths() == nullptr ? 0 : pixels.depths()->size();
    check.equal("number of depths", depths, with_depths * region_pixels);
    return check.reason();
}

std::string range_of(const schema::FrameDone& done) {
    const std::size_t regions = region_count(done.width(), done.height(), done.views());
    Check check;
    check.within("width", done.width(), 1, max_picture_px)
        .within("height", done.height(), 1, max_picture_px)
        .within("views", done.views(), 1, max_views)
        .length("moved_mm", done.moved_mm())
        .equal("number of region_cycles", std::size_t{done.region_cycles()->size()}, regions)
        .equal("number of region_renderers", std::size_t{done.region_renderers()->size()}, regions);
    for (const std::uint16_t renderer : *done.region_renderers()) {
        check.at_most("a region's Renderer", renderer, max_nodes - 1);
    }
    const std::size_t wanted = std::size_t{done.width()} * done.height() * done.views();
    if (done.pixels() != nullptr) {
        check.equal("number of pixels", std::size_t{done.pixels()->size()}, wanted);
    }
    if (done.depths() != nullptr) {
        check.equal("number of depths", std::size_t{done.depths()->size()}, wanted);
    }
    return check.reason();
}

std::string range_of(const schema::Activity& activity) {
    Check check;
    check.at_most("number of stages", activity.stages()->size(), max_stages);
    std::uint64_t left_ns = activity.wall_ns();
    for (const schema::StageTime* stage : *activity.stages()) {
        check.at_most("length of a stage's name", stage->name()->size(), max_stage_name);
        check.at_most("time of a stage beside the others", stage->ns(), left_ns);
        left_ns -= std::min(left_ns, stage->ns());
    }
    for (const schema::SentCount* sum : *activity.sent()) {
        check.within("kind", sum->kind(), 1, static_cast<std::size_t>(Body::MAX))
            .at_most("channel", sum->channel(), max_channels - 1);
    }
    return check.reason();
}

std::string range_of(const schema::PartCounts& part) {
    std::uint64_t cycles = 0;
    for (std::uint16_t i = 0; i < part.classes()->size(); ++i) {
        cycles += part.classes()->Get(i)->cycles();
    }
    return Check()
        .at_most("region", part.region(), max_regions - 1)
        .known("kind", part.kind())
        .at_most("surface", part.surface(), max_surfaces - 1)
        .at_most("slab", part.slab(), max_scene_slab)
        .at_most("primitives", part.primitives(), part.words())
        .at_most("port_cycles", part.port_cycles(), cycles)
        .at_most("backing_cycles beside the port's", part.backing_cycles(),
                 cycles - std::min(cycles, part.port_cycles()))
        .reason();
}

std::string range_of(const schema::FrameCounts& counts) {
    Check check;
    const schema::DrawnSlab* before = nullptr;
    for (const schema::DrawnSlab* slab : *counts.drawn()) {
        check.at_most("surface", slab->surface(), max_surfaces - 1)
            .at_most("slab", slab->slab(), max_scene_slab)
            .at_most("culled", slab->culled(), slab->primitives());
        if (before != nullptr && std::pair(before->surface(), before->slab()) >=
                                     std::pair(slab->surface(), slab->slab())) {
            check.add(fmt::format("surface {}, slab {} comes after surface {}, slab {}",
                                  slab->surface(), slab->slab(), before->surface(),
                                  before->slab()));
        }
        before = slab;
    }
    std::uint16_t region = 0;
    for (const schema::PartCounts* part : *counts.parts()) {
        check.add(range_of(*part));
        check.within("region", part->region(), region, max_regions - 1);
        region = part->region();
    }
    return check.reason();
}

constexpr std::size_t max_path_bytes = 4096;
constexpr std::uint64_t most_file_bytes = std::uint64_t{1} << 62;

std::string range_of(const schema::SlicesFile& file, std::uint64_t slice_bytes) {
    const std::string_view path = file.path()->string_view();
    Check check;
    check.within("length of a file's path", path.size(), 2, max_path_bytes)
        .equal("whether the file's path is absolute", path.starts_with('/'), true)
        .equal("whether the file's path has a zero byte", path.find('\0') != path.npos, false)
        .within("slices of a file", file.slices(), 1, max_volume_voxels)
        .finite("slope", file.slope())
        .finite("intercept", file.intercept())
        .at_most("size_bytes", file.size_bytes(), most_file_bytes)
        .at_most("offset", file.offset(), file.size_bytes());
    if (!check.reason().empty()) {
        return check.reason();  // The arithmetic below needs these fields.
    }
    return check
        .at_most("bytes of the values", file.slices() * slice_bytes,
                 file.size_bytes() - file.offset())
        .reason();
}

}  // namespace

std::string files_out_of_range(const schema::VolumeHeader& header, Elements& elements) {
    const schema::StoredVolume* stored = header.stored();
    Check check;
    check.within("reduction", header.reduction(), 1, max_volume_voxels);
    if (stored == nullptr) {
        return check.equal("whether a reduction has no file", header.reduction() > 1, false)
            .reason();
    }
    check.known("component", stored->component())
        .within("files of a volume", stored->files()->size(), 1, max_volume_voxels);
    if (!check.reason().empty()) {
        return check.reason();
    }
    const std::size_t value_bytes = component_bytes(stored->component());
    check.at_most("bits_stored", stored->bits_stored(), 8 * value_bytes);
    std::uint64_t slices = 0;
    for (const schema::SlicesFile* file : *stored->files()) {
        check.add(range_of(*file, std::uint64_t{header.nx()} * header.ny() * value_bytes));
        if (!elements.take(check, file->path()->size())) {
            return check.reason();
        }
        slices += file->slices();
    }
    return check.equal("slices of all files", slices, std::uint64_t{header.nz()}).reason();
}

std::string out_of_range(const schema::Message& message, std::size_t body_bytes) {
    switch (message.body_type()) {
        case Body::Hello:
            return range_of(*message.body_as_Hello());
        case Body::Topology:
            return range_of(*message.body_as_Topology());
        case Body::Fault:
            return range_of(*message.body_as_Fault());
        case Body::DrawFrame:
            return range_of(*message.body_as_DrawFrame());
        case Body::BeginFrame:
            return range_of(*message.body_as_BeginFrame());
        case Body::RegionPrograms:
            return range_of(*message.body_as_RegionPrograms(), Elements(body_bytes));
        case Body::RegionPixels:
            return range_of(*message.body_as_RegionPixels());
        case Body::FrameDone:
            return range_of(*message.body_as_FrameDone());
        case Body::Activity:
            return range_of(*message.body_as_Activity());
        case Body::FrameCounts:
            return range_of(*message.body_as_FrameCounts());
        default:
            return model_out_of_range(message, body_bytes);
    }
}

}  // namespace pxpl5::bus
