#include "ringbus/ranges.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <set>

#include "ringbus/channel_model.hpp"

namespace pxpl5::bus {

namespace {

using schema::Matrix;

/// Collects the first thing that is wrong.
class Check {
  public:
    template <typename Value, typename Limit>
    Check& within(const char* field, Value value, Limit low, Limit high) {
        if (!(value >= static_cast<Value>(low) && value <= static_cast<Value>(high))) {
            fail(fmt::format("{} is {}, allowed are {} .. {}", field, value, low, high));
        }
        return *this;
    }
    template <typename Value>
    Check& equal(const char* field, Value value, Value wanted) {
        if (value != wanted) {
            fail(fmt::format("{} is {}, expected {}", field, value, wanted));
        }
        return *this;
    }
    Check& finite(const char* field, const Matrix& matrix) {
        for (const double value : *matrix.m()) {
            if (!std::isfinite(value)) {
                fail(fmt::format("{} holds {}", field, value));
            }
        }
        return *this;
    }
    Check& finite(const char* field, double value) {
        if (!std::isfinite(value)) {
            fail(fmt::format("{} is {}", field, value));
        }
        return *this;
    }
    Check& add(const std::string& reason) {
        if (!reason.empty()) {
            fail(reason);
        }
        return *this;
    }
    template <typename Enum>
    Check& known(const char* field, Enum value) {
        return within(field, static_cast<int>(value), static_cast<int>(Enum::MIN),
                      static_cast<int>(Enum::MAX));
    }
    template <typename Value>
    Check& at_most(const char* field, Value value, Value limit) {
        if (!(value <= limit)) {
            fail(fmt::format("{} is {}, allowed are at most {}", field, value, limit));
        }
        return *this;
    }
    const std::string& reason() const { return reason_; }

  private:
    void fail(const std::string& reason) {
        if (reason_.empty()) {
            reason_ = reason;
        }
    }
    std::string reason_;
};

template <typename Vector>
std::size_t size_of(const Vector* vector) {
    return vector == nullptr ? 0 : vector->size();
}

std::string range_of(const schema::Hello& hello) {
    return Check().known("role", hello.role()).reason();
}

std::string range_of(const schema::Topology& topology) {
    Check check;
    check
        .within("number of nodes", std::size_t{topology.nodes()->size()}, std::size_t{1}, max_nodes)
        .within("ring channels", std::size_t{topology.ring_channels()}, std::size_t{1},
                max_channels);
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
    return Check().known("code", fault.code()).reason();
}

std::string range_of(const schema::VolumeHeader& header) {
    return Check()
        .within("nx", header.nx(), min_volume_voxels, max_volume_voxels)
        .within("ny", header.ny(), min_volume_voxels, max_volume_voxels)
        .within("nz", header.nz(), min_volume_voxels, max_volume_voxels)
        .known("type", header.type())
        .finite("voxel_to_patient", *header.voxel_to_patient())
        .finite("minimum", header.minimum())
        .finite("maximum", header.maximum())
        .at_most("minimum", header.minimum(), header.maximum())
        .reason();
}

std::string range_of(const schema::Slices& slices) {
    const std::uint32_t count = slices.slice_count();
    Check check;
    check.within("slice_count", count, 1U, max_volume_voxels);
    if (!check.reason().empty()) {
        return check.reason();  // What follows divides by it and subtracts it.
    }
    return check.within("first_slice", slices.first_slice(), 0U, max_volume_voxels - count)
        .equal("bytes beyond whole slices", slices.values()->size() % count, 0U)
        .reason();
}

std::string range_of(const schema::ExportPicture& picture) {
    return Check()
        .within("width", picture.width(), 1U, 2 * max_picture_px)
        .within("height", picture.height(), 1U, 2 * max_picture_px)
        .equal("size of rgba", std::size_t{picture.rgba()->size()},
               std::size_t{picture.width()} * picture.height() * 4)
        .reason();
}

std::string range_of(const schema::SetSurface& surface) {
    return Check().finite("isovalue", surface.isovalue()).known("table", surface.table()).reason();
}

std::string range_of(const schema::SurfaceBuilt& built) {
    Check check;
    const schema::SlabCounts* last = nullptr;
    for (const auto* slab : *built.slabs()) {
        check.within("slab", slab->slab(), last == nullptr ? 0U : last->slab() + 1, max_slab)
            .finite("area_mm2", slab->area_mm2())
            .finite("volume_mm3", slab->volume_mm3());
        last = slab;
    }
    return check.reason();
}

bool is_finite(const schema::MeshVertex& v) {
    return std::isfinite(v.x()) && std::isfinite(v.y()) && std::isfinite(v.z()) &&
           std::isfinite(v.nx()) && std::isfinite(v.ny()) && std::isfinite(v.nz());
}

std::string range_of(const schema::SlabMesh& mesh) {
    const auto& vertices = *mesh.vertices();
    const auto& indices = *mesh.indices();
    Check check;
    check.at_most("slab", mesh.slab(), max_slab)
        .equal("number of keys", mesh.keys()->size(), vertices.size())
        .equal("indices beyond whole triangles", indices.size() % 3, 0U);
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
    return check.reason();
}

std::string range_of(const schema::MeshPart& part) {
    Check check;
    for (const auto* slab : *part.slabs()) {
        check.add(range_of(*slab));
    }
    return check.reason();
}

std::string range_of(const schema::SceneBegin& begin) {
    const auto& surfaces = *begin.surfaces();
    return Check()
        .within("number of surfaces", std::size_t{surfaces.size()}, std::size_t{0},
                max_scene_surfaces)
        .equal("number of different surfaces",
               std::set<std::uint16_t>(surfaces.begin(), surfaces.end()).size(),
               std::size_t{surfaces.size()})
        .reason();
}

std::string range_of(const schema::ScenePart& part) {
    const auto& vertices = *part.vertices();
    const auto& indices = *part.indices();
    Check check;
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

std::string range_of(const schema::DrawFrame& draw) {
    Check check;
    check.within("width", draw.width(), 1U, max_picture_px)
        .within("height", draw.height(), 1U, max_picture_px)
        .within("number of views", std::size_t{draw.views()->size()}, std::size_t{1}, max_views)
        .within("number of lights", std::size_t{draw.lights()->size()}, std::size_t{0}, max_lights)
        .within("number of surfaces", std::size_t{draw.surfaces()->size()}, std::size_t{0},
                max_surfaces)
        .within("number of clip planes", size_of(draw.clip_planes()), std::size_t{0},
                max_clip_planes)
        .within("specular_power", draw.specular_power(), 1U, max_specular_power)
        .within("ambient", draw.ambient(), 0.0F, 1.0F)
        .within("specular", draw.specular(), 0.0F, 1.0F);
    for (const auto* view : *draw.views()) {
        check.finite("voxel_to_eye", *view->voxel_to_eye())
            .finite("projection", *view->projection());
    }
    for (const auto* light : *draw.lights()) {
        const schema::Vec3& d = light->direction();
        const float length = std::sqrt(d.x() * d.x() + d.y() * d.y() + d.z() * d.z());
        check.within("length of a light's direction", length, 0.999F, 1.001F)
            .within("intensity", light->intensity(), 0.0F, 16.0F);
    }
    for (std::size_t i = 0; i < size_of(draw.clip_planes()); ++i) {
        const auto* plane = draw.clip_planes()->Get(static_cast<flatbuffers::uoffset_t>(i));
        check.finite("clip plane", plane->a()).finite("clip plane", plane->b());
        check.finite("clip plane", plane->c()).finite("clip plane", plane->d());
    }
    return check.reason();
}

std::string range_of(const schema::BeginFrame& begin) {
    const schema::DrawFrame& draw = *begin.draw();
    Check check;
    check.add(range_of(draw))
        .equal("size of assignment", std::size_t{begin.assignment()->size()},
               region_count(draw.width(), draw.height(), draw.views()->size()));
    for (const std::uint16_t renderer : *begin.assignment()) {
        check.at_most("assigned Renderer", std::size_t{renderer}, max_nodes - 1);
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

std::string range_of(const schema::RegionPrograms& programs) {
    Check check;
    check.at_most("gp", std::size_t{programs.gp()}, max_nodes - 1);
    for (const auto* region : *programs.regions()) {
        check.at_most("region", std::size_t{region->region()}, max_regions - 1);
        check.add(range_of(*region));
    }
    return check.reason();
}

std::string range_of(const schema::RegionPixels& pixels) {
    Check check;
    check.at_most("renderer", std::size_t{pixels.renderer()}, max_nodes - 1)
        .equal("number of pixels", std::size_t{pixels.pixels()->size()},
               std::size_t{pixels.tiles()->size()} * region_pixels);
    for (const auto* tile : *pixels.tiles()) {
        check.at_most("region", std::size_t{tile->region()}, max_regions - 1);
    }
    return check.reason();
}

std::string range_of(const schema::FrameDone& done) {
    Check check;
    check.within("width", done.width(), 1U, max_picture_px)
        .within("height", done.height(), 1U, max_picture_px)
        .within("views", std::size_t{done.views()}, std::size_t{1}, max_views)
        .equal("number of region_cycles", std::size_t{done.region_cycles()->size()},
               region_count(done.width(), done.height(), done.views()));
    if (done.pixels() != nullptr) {
        check.equal("number of pixels", std::size_t{done.pixels()->size()},
                    std::size_t{done.width()} * done.height() * done.views());
    }
    return check.reason();
}

}  // namespace

std::string out_of_range(const schema::Message& message) {
    switch (message.body_type()) {
        case Body::Hello:
            return range_of(*message.body_as_Hello());
        case Body::Topology:
            return range_of(*message.body_as_Topology());
        case Body::Fault:
            return range_of(*message.body_as_Fault());
        case Body::VolumeHeader:
            return range_of(*message.body_as_VolumeHeader());
        case Body::Slices:
            return range_of(*message.body_as_Slices());
        case Body::ExportPicture:
            return range_of(*message.body_as_ExportPicture());
        case Body::SetSurface:
            return range_of(*message.body_as_SetSurface());
        case Body::SurfaceBuilt:
            return range_of(*message.body_as_SurfaceBuilt());
        case Body::MeshPart:
            return range_of(*message.body_as_MeshPart());
        case Body::SceneBegin:
            return range_of(*message.body_as_SceneBegin());
        case Body::ScenePart:
            return range_of(*message.body_as_ScenePart());
        case Body::DrawFrame:
            return range_of(*message.body_as_DrawFrame());
        case Body::BeginFrame:
            return range_of(*message.body_as_BeginFrame());
        case Body::RegionPrograms:
            return range_of(*message.body_as_RegionPrograms());
        case Body::RegionPixels:
            return range_of(*message.body_as_RegionPixels());
        case Body::FrameDone:
            return range_of(*message.body_as_FrameDone());
        default:
            return {};  // The others hold nothing that could be out of range.
    }
}

}  // namespace pxpl5::bus
