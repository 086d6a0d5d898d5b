#include "host/inspect/why/replayed_gp.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "gp_firmware/node/messages.hpp"
#include "gp_firmware/render/draw_slab.hpp"
#include "gp_firmware/surface/marching_cubes.hpp"
#include "gp_firmware/volume/slice_store.hpp"
#include "ringbus/rules/slice_planes.hpp"

namespace pxpl5::host::inspect {

namespace {

namespace schema = bus::schema;

/// The words that the GPs sent of a slab for a region; empty if there are none.
renderer::Words recorded_words(const RecordedRegion& region, std::uint32_t surface, int k) {
    for (const renderer::RegionPlan::Part& part : region.plan.parts) {
        if (part.kind == PartKind::segment && part.segment.surface == surface &&
            part.segment.slab == static_cast<std::uint32_t>(k)) {
            return part.segment.words;
        }
    }
    return {};
}

/// The masks that one GP went by when it drew the frame, of its own slabs.
void take_masks(const RecordedRun& run, std::uint32_t frame, std::uint32_t gp, ShownSurface& s) {
    const NodeTrace* trace = run.find(schema::Role::gp, gp);
    std::optional<bus::Message> header, mask;
    for (std::size_t n = 0; trace != nullptr && n < trace->entries.size(); ++n) {
        const bus::Body kind = trace->entries[n].kind();
        if (kind != bus::Body::VolumeHeader && kind != bus::Body::SetSurface &&
            kind != bus::Body::MaskSurface && kind != bus::Body::DrawFrame &&
            kind != bus::Body::BeginFrame) {
            continue;
        }
        const bus::Message message = trace->load(trace->entries[n]);
        const auto* draw = message.as<schema::DrawFrame>();
        const auto* begin = message.as<schema::BeginFrame>();
        if ((draw != nullptr && draw->frame() == frame) ||
            (begin != nullptr && begin->draw()->frame() == frame)) {
            break;
        }
        const auto* set = message.as<schema::SetSurface>();
        const auto* newer = message.as<schema::MaskSurface>();
        if (kind == bus::Body::VolumeHeader) {
            header = message;
            mask.reset();
        } else if (set != nullptr && set->surface() == s.id) {
            mask.reset();
        } else if (newer != nullptr && newer->surface() == s.id &&
                   newer->revision() == s.revision) {
            mask = message;
        }
    }
    if (!header || !mask) {
        return;
    }
    const gp::VolumeShape shape = gp::shape_of(*header->as<schema::VolumeHeader>());
    for (const schema::SlabMask* slab : *mask->as<schema::MaskSurface>()->slabs()) {
        const int k = static_cast<int>(slab->slab());
        if (gp::slab_sets(shape, static_cast<int>(run.gp_count())).owner(k) ==
            static_cast<int>(gp)) {
            s.hidden[k].assign(slab->hidden()->begin(), slab->hidden()->end());
        }
    }
}

}  // namespace

std::vector<ShownSurface> surfaces_of(const RecordedRun& run, const RecordedFrame& frame) {
    std::vector<ShownSurface> surfaces;
    for (const schema::SurfaceDraw* drawn : *frame.draw().surfaces()) {
        ShownSurface& s = surfaces.emplace_back();
        s.index = static_cast<std::uint32_t>(surfaces.size() - 1);
        s.id = drawn->surface();
        s.revision = drawn->revision();
        s.color = {drawn->color().r(), drawn->color().g(), drawn->color().b()};
        s.cull_back = drawn->cull_back();
        s.detail = drawn->detail();
        s.slabs = drawn->slabs();
        s.opacity = drawn->opacity();
        s.rim = drawn->rim();
        if (const auto* plane = bus::plane_at(frame.draw(), s.index)) {
            s.plane = gp::slice_plane_of(*plane);
            continue;
        }
        if (const auto message = run.surface(s.id, s.revision)) {
            const auto& set = *message->as<schema::SetSurface>();
            s.isovalue = set.isovalue();
            s.rule = set.table();
        }
        for (std::uint32_t gp = 0; gp < run.gp_count(); ++gp) {
            take_masks(run, frame.number, gp, s);
        }
    }
    return surfaces;
}

// A high volume may have other slabs in the share. Slices of zeros are enough for them, because
// slabs do not depend on each other.
gp::SlabMesh replay_extraction(const KnownVolume& volume, int k, double isovalue, CaseRule rule) {
    const gp::Share share{k % max_nodes_per_role, max_nodes_per_role};
    gp::VolumeShape shape = volume.shape();
    shape.slabs_per_set = 1;  // A slab is the same in sets of any size: the smallest is cheapest.
    gp::LocalMemory plenty(std::numeric_limits<std::size_t>::max());
    gp::SliceStore store(shape, share, plenty);
    const std::vector<std::byte> zeros(shape.slice_voxels() * size_bytes(shape.type));
    for (const int z : gp::slices_needed(shape, share)) {
        const bool ours = z >= k - slices_below && z <= k + slices_above;
        store.add_slice(z, ours ? volume.slice(z) : std::span<const std::byte>(zeros));
    }
    gp::SlabMesh mesh;
    gp::extract_slab(store, k, isovalue, gp::case_table(rule), mesh, true);
    return mesh;
}

ReplayedGp::ReplayedGp(const RecordedFrame& frame, const std::vector<ShownSurface>& surfaces,
                       KnownVolume& volume)
    : frame_(frame), surfaces_(surfaces), volume_(volume) {
    if (!volume.has_shape()) {
        throw std::logic_error("stages are replayed only if the volume's header is recorded");
    }
    cameras_ = gp::frame_request(frame.draw(), volume.shape()).views;
    std::ranges::transform(cameras_, std::back_inserter(projections_), gp::prepare);
}

std::string ReplayedGp::missing(std::uint32_t surface, int k) {
    if (surfaces_.at(surface).plane) {
        return fmt::format("surface {} is a slice of the volume, which has no voxel cells",
                           surface);
    }
    if (!surfaces_.at(surface).isovalue) {
        return fmt::format("no trace holds the SetSurface of surface {} (id {}, revision {})",
                           surface, surfaces_.at(surface).id, surfaces_.at(surface).revision);
    }
    if (const int detail = surfaces_.at(surface).detail; detail > 0) {
        return fmt::format("surface {} is simplified in this frame (detail {}); draw it exactly",
                           surface, detail);
    }
    const int slabs = volume_.shape().slab_count();
    if (k < 0 || k >= slabs) {
        return fmt::format("slab {} is outside of the volume, which has {} slabs", k, slabs);
    }
    return volume_.need(k - slices_below, k + slices_above);
}

bool ReplayedGp::draws(std::uint32_t surface, int k) const {
    return gp::draws_slab(surfaces_.at(surface).slabs, k, volume_.shape().gap_slabs);
}

gp::RegionGrid ReplayedGp::grid(int view) const {
    return gp::region_grid(camera(view).width_px, camera(view).height_px, view);
}

const gp::SlabMesh& ReplayedGp::mesh(std::uint32_t surface, int k) {
    const auto found = meshes_.find({surface, k});
    if (found != meshes_.end()) {
        return found->second;
    }
    return meshes_[{surface, k}] = replay_extraction(volume_, k, *surfaces_.at(surface).isovalue,
                                                     surfaces_.at(surface).rule);
}

const ReplayedSlab& ReplayedGp::slab(std::uint32_t surface, int k, int view) {
    ReplayedSlab& again = slabs_[{{surface, k}, view}];
    if (again.mesh.origins.empty()) {
        again.mesh = mesh(surface, k);
        again.screen = gp::transformed(again.mesh.vertices, projection(view));
    }
    return again;
}

std::span<const std::uint8_t> ReplayedGp::hidden(std::uint32_t surface, int k) {
    const auto found = surfaces_.at(surface).hidden.find(k);
    // A mask of a wrong size was refused.
    return found == surfaces_.at(surface).hidden.end() ||
                   found->second.size() != (mesh(surface, k).indices.size() / 3 + 7) / 8
               ? std::span<const std::uint8_t>()
               : found->second;
}

const gp::RegionPrograms& ReplayedGp::programs(std::uint32_t surface, int k) {
    const auto [at, is_new] = programs_.try_emplace({surface, k});
    if (is_new) {
        const int views = static_cast<int>(cameras_.size());
        at->second.begin_frame(static_cast<std::size_t>(grid(0).count() * views), true);
        at->second.begin_slab(static_cast<std::uint16_t>(surface), static_cast<std::uint32_t>(k));
        gp::DrawScratch scratch;
        for (int view = 0; draws(surface, k) && view < views; ++view) {
            gp::draw_slab(mesh(surface, k), projection(view), grid(view),
                          {static_cast<std::uint16_t>(surface), surfaces_.at(surface).cull_back,
                           hidden(surface, k)},
                          scratch, at->second);
        }
        at->second.end_frame();
    }
    return at->second;
}

std::string ReplayedGp::difference(std::uint32_t surface, int k) {
    const gp::RegionPrograms& again = programs(surface, k);
    for (const auto& [number, region] : frame_.regions) {
        const renderer::Words recorded = recorded_words(region, surface, k);
        std::vector<std::uint32_t> words(again.regions()[number].word_count());
        gp::write_words(again, number, grid(0), words.data());
        if (!std::ranges::equal(recorded, words)) {
            return fmt::format(
                "slab {} of surface {}, drawn again, gives {} words in region "
                "({}, {}), recorded are {}{}",
                k, surface, words.size(), region.place.column, region.place.row, recorded.size(),
                words.size() == recorded.size() ? " others" : "");
        }
    }
    return {};
}

ReplayedCell ReplayedGp::cell(std::uint32_t surface, int i, int j, int k) const {
    ReplayedCell cell;
    for (int c = 0; c < 8; ++c) {
        const double value = volume_.value(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2));
        cell.values[static_cast<std::size_t>(c)] = value;
        if (value >= *surfaces_.at(surface).isovalue) {
            cell.inside |= static_cast<std::uint8_t>(1U << c);
        }
    }
    return cell;
}

}  // namespace pxpl5::host::inspect
