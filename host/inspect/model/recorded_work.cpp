#include "host/inspect/model/recorded_work.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <utility>

#include "gp_firmware/node/messages.hpp"
#include "host/base/error.hpp"
#include "host/inspect/model/part_work.hpp"
#include "host/inspect/why/replayed_gp.hpp"
#include "host/timing/counts/runs.hpp"
#include "ringbus/rules/slice_planes.hpp"

namespace pxpl5::host::inspect {

namespace {

namespace schema = bus::schema;
using bus::Body;
using timing::SlabWork;

/// A surface's revision, as on the ring.
using SurfaceKey = std::pair<std::uint16_t, std::uint32_t>;
using Slabs = std::map<std::uint32_t, SlabWork>;

/// Calls take(message) with every message of these kinds that the node received, in order.
template <typename Take>
void for_messages(const NodeTrace& node, std::initializer_list<Body> kinds, const Take& take) {
    for (const bus::trace::Entry& entry : node.entries) {
        if (std::ranges::find(kinds, entry.kind()) != kinds.end()) {
            take(node.load(entry));
        }
    }
}

/// The counts that the GPs reported of their slabs, by revision.
std::map<SurfaceKey, Slabs> told_slabs(const RecordedRun& run) {
    std::map<SurfaceKey, Slabs> told;
    const NodeTrace* host = run.find(schema::Role::host, 0);
    if (host == nullptr) {
        return told;
    }
    for_messages(*host, {Body::SurfaceBuilt}, [&](const bus::Message& message) {
        const auto& built = *message.as<schema::SurfaceBuilt>();
        Slabs& slabs = told[{built.surface(), built.revision()}];
        for (const schema::SlabCounts* slab : *built.slabs()) {
            slabs[slab->slab()] = {slab->slab(), slab->cells_active(), slab->vertices(),
                                   slab->triangles()};
        }
    });
    return told;
}

/// Surfaces with slabs that did not fit into a GP's memory.
std::set<SurfaceKey> left_out_surfaces(const RecordedRun& run) {
    std::set<SurfaceKey> found;
    if (const NodeTrace* host = run.find(schema::Role::host, 0)) {
        for_messages(*host, {Body::SurfaceBuilt}, [&](const bus::Message& message) {
            const auto& built = *message.as<schema::SurfaceBuilt>();
            if (built.left_out() > 0) {
                found.insert({built.surface(), built.revision()});
            }
        });
    }
    return found;
}

/// Primitives of scenes: by scene and surface, then by slab.
using Scenes =
    std::map<std::pair<std::uint32_t, std::uint16_t>, std::map<std::uint32_t, std::uint64_t>>;

Scenes recorded_scenes(const RecordedRun& run) {
    Scenes scenes;
    for (const auto& [id, node] : run.nodes()) {
        for_messages(node, {Body::ScenePart}, [&](const bus::Message& message) {
            const auto& part = *message.as<schema::ScenePart>();
            scenes[{part.scene(), part.surface()}][part.slab()] =
                part.indices()->size() / 3 + part.spheres()->size() + part.lines()->size();
        });
    }
    return scenes;
}

/// True if the node recorded everything that it received.
bool has_all(const NodeTrace* node) {
    return node != nullptr && node->info.recording == Recording::full && node->cut.empty();
}

/// Follows the host's commands in the order in which GP 0 received them.
class WorkReader {
  public:
    WorkReader(const RecordedRun& run, const std::vector<Range>& frames)
        : run_(run),
          frames_(frames),
          told_(told_slabs(run)),
          left_out_(left_out_surfaces(run)),
          scenes_(recorded_scenes(run)) {}

    timing::RunWork read();

  private:
    void take(const bus::Message& message);
    void take_volume();
    void take_surface(const schema::SetSurface& set);
    void take_frame(const schema::DrawFrame& draw);

    std::optional<Slabs> slabs_of(const schema::SetSurface& set);
    std::vector<timing::DrawnSlab> drawn_slabs(const schema::DrawFrame& draw) const;
    std::map<std::uint32_t, std::uint64_t> primitives_of(const schema::SurfaceDraw& surface) const;
    std::map<std::uint32_t, std::uint64_t> primitives_of(const gp::SlicePlane& plane) const;
    std::string why_not(const RecordedFrame& frame,
                        const std::vector<timing::DrawnSlab>& drawn) const;
    void miss(std::string sentence) { work_.missing.push_back(std::move(sentence)); }

    const RecordedRun& run_;
    const std::vector<Range>& frames_;
    const std::map<SurfaceKey, Slabs> told_;
    const std::set<SurfaceKey> left_out_;
    const Scenes scenes_;
    timing::RunWork work_;
    std::optional<KnownVolume> volume_;  ///< Volume in the GPs,
    bool volume_counted_ = false;
    std::optional<std::uint32_t> scene_;  ///< or this.
    std::map<SurfaceKey, Slabs> surfaces_;
};

timing::RunWork WorkReader::read() {
    const NodeTrace* master = run_.find(schema::Role::gp, 0);
    if (master == nullptr) {
        throw RequestError(
            ExitCode::bad_data,
            fmt::format("the trace of gp-0, which receives all requests of the host, "
                        "is not among {} traces",
                        run_.nodes().size()));
    }
    for_messages(*master,
                 {Body::VolumeHeader, Body::VolumeEnd, Body::DropVolume, Body::SceneBegin,
                  Body::SetSurface, Body::DrawFrame},
                 [this](const bus::Message& message) { take(message); });
    return std::move(work_);
}

void WorkReader::take(const bus::Message& message) {
    if (message.kind() == Body::VolumeEnd) {
        take_volume();
    } else if (const auto* set = message.as<schema::SetSurface>()) {
        take_surface(*set);
    } else if (const auto* draw = message.as<schema::DrawFrame>()) {
        take_frame(*draw);
    } else {  // Something else takes the place of what was held.
        volume_.reset();
        scene_.reset();
        surfaces_.clear();
        volume_counted_ = false;
        if (message.kind() == Body::VolumeHeader) {
            volume_.emplace(run_.volume_of(message));
        } else if (const auto* scene = message.as<schema::SceneBegin>()) {
            scene_ = scene->scene();
        }
    }
}

void WorkReader::take_volume() {
    if (!volume_) {
        return;  // Dropped before.
    }
    const schema::VolumeHeader& header = volume_->header();
    const gp::VolumeShape& shape = volume_->shape();
    if (const std::string lacking = volume_->need(0, shape.nz - 1); !lacking.empty()) {
        miss(fmt::format("volume {} and the surfaces built from it: {}", header.volume(), lacking));
        return;
    }
    timing::VolumeWork work{header.name()->str(),
                            header.nx(),
                            header.ny(),
                            header.nz(),
                            static_cast<std::uint32_t>(size_bytes(shape.type)),
                            {},
                            shape.gradient};
    for (int z = 0; z < shape.nz; ++z) {
        work.runs.push_back(
            timing::runs_of(volume_->slice(z), {work.nx, work.ny, work.voxel_bytes}));
    }
    work_.steps.emplace_back(std::move(work));
    volume_counted_ = true;
}

/// The slabs of the revision, reported by GPs or else extracted; empty if neither is possible.
std::optional<Slabs> WorkReader::slabs_of(const schema::SetSurface& set) {
    const auto told = told_.find({set.surface(), set.revision()});
    Slabs slabs = told == told_.end() ? Slabs() : told->second;
    const auto all = static_cast<std::uint32_t>(volume_->shape().nz - 1);
    if (slabs.size() < all && has_all(run_.find(schema::Role::host, 0))) {
        miss(fmt::format(
            "surface {}, revision {}: a newer revision replaced it after {} of {} slabs",
            set.surface(), set.revision(), slabs.size(), all));
        return std::nullopt;
    }
    for (std::uint32_t k = 0; k < all; ++k) {
        if (slabs.contains(k)) {
            continue;
        }
        const int slab = static_cast<int>(k);
        const std::string lacking = volume_->need(slab - slices_below, slab + slices_above);
        if (!lacking.empty()) {
            miss(
                fmt::format("surface {}, revision {}: {}", set.surface(), set.revision(), lacking));
            return std::nullopt;
        }
        const gp::SlabCounts counts =
            replay_extraction(*volume_, slab, set.isovalue(), set.table()).counts;
        slabs[k] = {k, counts.cells_active, counts.vertices, counts.triangles};
    }
    return slabs;
}

void WorkReader::take_surface(const schema::SetSurface& set) {
    std::optional<Slabs> slabs = volume_ ? slabs_of(set) : std::nullopt;
    if (!slabs) {
        return;
    }
    if (volume_counted_) {  // Otherwise a sentence about the volume names the surfaces.
        timing::BuildWork build{set.surface(), set.revision(), set.isovalue(), {}};
        for (const auto& [k, slab] : *slabs) {
            build.slabs.push_back(slab);
        }
        work_.steps.emplace_back(std::move(build));
    }
    surfaces_[{set.surface(), set.revision()}] = *std::move(slabs);
}

/// By slab, of one view; no slab without any.
std::map<std::uint32_t, std::uint64_t> WorkReader::primitives_of(
    const schema::SurfaceDraw& surface) const {
    std::map<std::uint32_t, std::uint64_t> primitives;
    if (scene_) {
        const auto found = scenes_.find({*scene_, surface.surface()});
        return found == scenes_.end() ? primitives : found->second;
    }
    const auto found = surfaces_.find({surface.surface(), surface.revision()});
    for (const auto& [k, slab] : found == surfaces_.end() ? Slabs() : found->second) {
        if (slab.triangles != 0 &&
            gp::draws_slab(surface.slabs(), static_cast<int>(k), volume_->shape().gap_slabs)) {
            primitives[k] = slab.triangles;
        }
    }
    return primitives;
}

std::map<std::uint32_t, std::uint64_t> WorkReader::primitives_of(
    const gp::SlicePlane& plane) const {
    std::map<std::uint32_t, std::uint64_t> primitives;
    for (int slab = 0; volume_ && slab < volume_->shape().slab_count(); ++slab) {
        if (const std::uint32_t count = plane_triangles(plane, volume_->shape(), slab); count > 0) {
            primitives[static_cast<std::uint32_t>(slab)] = count;
        }
    }
    return primitives;
}

std::vector<timing::DrawnSlab> WorkReader::drawn_slabs(const schema::DrawFrame& draw) const {
    std::vector<timing::DrawnSlab> drawn;
    for (std::uint32_t index = 0; index < draw.surfaces()->size(); ++index) {
        const auto* plane = bus::plane_at(draw, index);
        for (const auto& [slab, primitives] : plane != nullptr
                                                  ? primitives_of(gp::slice_plane_of(*plane))
                                                  : primitives_of(*draw.surfaces()->Get(index))) {
            drawn.push_back({index, slab, primitives * draw.views()->size()});
        }
    }
    return drawn;
}

/// Empty if all of the frame can be counted, else what is missing.
std::string WorkReader::why_not(const RecordedFrame& frame,
                                const std::vector<timing::DrawnSlab>& drawn) const {
    if (!frame.missing.empty()) {
        return fmt::format("{}", fmt::join(frame.missing, "; "));
    }
    for (const schema::SurfaceDraw* surface : *frame.draw().surfaces()) {
        if (surface->detail() > 0) {
            return fmt::format(
                "surface {} is simplified (detail {}), and the model knows exact "
                "surfaces only",
                surface->surface(), surface->detail());
        }
        if (left_out_.contains({surface->surface(), surface->revision()})) {
            return fmt::format(
                "surface {} has slabs that the GPs extracted again for each frame, and the model "
                "knows surfaces in memory only",
                surface->surface());
        }
    }
    std::uint64_t told = 0, counted = 0;
    for (const auto& [gp, message] : frame.inputs.begin()->second.programs) {
        told += message.as<schema::RegionPrograms>()->triangles_in();
    }
    for (const timing::DrawnSlab& slab : drawn) {
        counted += slab.primitives / frame.draw().views()->size();
    }
    return told == counted ? ""
                           : fmt::format("GPs told of {} primitives, recorded are {} of its slabs",
                                         told, counted);
}

void WorkReader::take_frame(const schema::DrawFrame& draw) {
    const std::uint32_t number = draw.frame();
    // The picture's passes are numbered one after the other.
    const std::uint32_t first = number - draw.sample(), last = first + draw.samples() - 1;
    const auto holds = [&](const Range& range) { return range.from <= last && first <= range.to; };
    if (!frames_.empty() && std::ranges::none_of(frames_, holds)) {
        return;
    }
    if (!std::ranges::binary_search(run_.frames(), number)) {
        return miss(fmt::format("frame {}: no trace has its BeginFrame", number));
    }
    const RecordedFrame frame = run_.frame(number);
    timing::FrameWork work{number,
                           draw.width(),
                           draw.height(),
                           draw.views()->size(),
                           frame.has_pixels(),
                           drawn_slabs(draw),
                           {},
                           {}};
    if (const std::string lacking = why_not(frame, work.drawn); !lacking.empty()) {
        return miss(fmt::format("frame {}: {}", number, lacking));
    }
    const auto& assignment = *frame.begin->as<schema::BeginFrame>()->assignment();
    work.assignment.assign(assignment.begin(), assignment.end());
    work.sample = draw.sample();
    work.samples = draw.samples();
    work.parts = part_work(frame);
    work_.steps.emplace_back(std::move(work));
}

}  // namespace

timing::RunWork recorded_work(const RecordedRun& run, const std::vector<Range>& frames) {
    return WorkReader(run, frames).read();
}

}  // namespace pxpl5::host::inspect
