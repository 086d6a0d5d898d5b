// A GP's surfaces: extracting, keeping, handing over, hiding and measuring them.
#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <utility>

#include "gp_firmware/node/messages.hpp"
#include "gp_firmware/node/node.hpp"
#include "gp_firmware/surface/marching_cubes.hpp"

namespace pxpl5::gp {

namespace {

namespace schema = bus::schema;
using bus::NodeFault;
using schema::FaultCode;

/// What measuring costs, about, in nanoseconds: enough to cut it into pieces of a few ms.
constexpr std::size_t ns_per_crossed_cell = 40, ns_per_row = 60, cells_per_ns = 4;
constexpr std::size_t piece_ns = 8'000'000;
constexpr std::size_t triangles_per_piece = 50'000;  ///< Of an extraction: some 1 ms.

std::size_t mesh_bytes(const HeldSurface& surface) {
    std::size_t bytes = 0;
    for (const SlabMesh& mesh : surface.slabs) {
        bytes += size_bytes(mesh);
    }
    return bytes;
}

/// Copies with no more room than it takes, or little more where the room is there already.
template <class T>
void copy_closely(const std::vector<T>& from, std::vector<T>& to) {
    if (to.capacity() < from.size() || to.capacity() / 2 > from.size()) {
        to = std::vector<T>();  // Frees; an empty list would not.
        to.reserve(from.size());
    }
    to.assign(from.begin(), from.end());
}

void copy_closely(const SlabMesh& from, SlabMesh& to) {
    to.slab = from.slab;
    to.counts = from.counts;
    copy_closely(from.vertices, to.vertices);
    copy_closely(from.keys, to.keys);
    copy_closely(from.indices, to.indices);
    copy_closely(from.origins, to.origins);
}

/// Whether the mesh could do with half of its room: a few pages do not count.
bool is_roomy(const SlabMesh& mesh) {
    constexpr std::size_t spare_bytes = 4096;
    const std::size_t used_bytes = mesh.vertices.size() * (sizeof(Vertex) + sizeof(std::uint64_t)) +
                                   mesh.indices.size() * sizeof(std::uint32_t);
    return size_bytes(mesh) > 2 * used_bytes + spare_bytes;
}

std::size_t cost_ns(const VolumeShape& shape, const SlabCounts& counts) {
    const auto rows = static_cast<std::size_t>(shape.ny - 1);
    const std::size_t looked_at = (rows - counts.rows_skipped) * static_cast<std::size_t>(shape.nx);
    return rows * ns_per_row + looked_at / cells_per_ns + counts.cells_active * ns_per_crossed_cell;
}

}  // namespace

bool GpNode::step(Extract& job, bus::Outbox& out) {
    const bus::StageClock::In extracting(out.clock(), stage::extract);
    if (!store_->complete()) {
        throw NodeFault(FaultCode::bad_input,
                        fmt::format("surface {} was asked for before all slices of volume {} came",
                                    job.surface, *volume_));
    }
    HeldSurface& surface = surfaces_[job.surface];
    if (job.next_slab == 0) {
        surface.revision = job.revision;
        surface.isovalue = job.isovalue;
        surface.rule = job.rule;
        surface.complete = false;
        surface.slabs.resize(store_->slabs().size());
        surface.hidden.clear();
    }
    if (job.next_slab < surface.slabs.size()) {
        try {
            extract_next(job, surface);
        } catch (...) {
            drop_surface(job.surface);
            throw;
        }
    }
    if (job.next_slab < surface.slabs.size()) {
        return false;
    }
    surface.complete = true;
    out.send(bus::host_id, surface_built_message(job.surface, surface, memory_->used_bytes(),
                                                 to_us(Clock::now() - job.since)));
    return true;
}

/// Extracts a slab over the older revision's: there is no room for both.
void GpNode::extract_next(Extract& job, HeldSurface& surface) {
    SlabMesh& mesh = surface.slabs[job.next_slab];
    const std::size_t before = size_bytes(mesh);
    if (!job.slab_begun) {
        job.slab_begun = true;
        extraction_ = begin_slab(*store_, store_->slabs()[job.next_slab], job.isovalue,
                                 case_table(job.rule), scratch_, machine_->origins);
    }
    if (extraction_(triangles_per_piece)) {
        return;
    }
    job.slab_begun = false;
    if (store_->shape().holds_gradients() && !is_roomy(scratch_)) {
        std::swap(scratch_, mesh);  // A small volume: time counts, not some room to grow in.
    } else {
        copy_closely(scratch_, mesh);
    }
    ++job.next_slab;
    memory_->release(before);
    try {
        const std::size_t bytes = size_bytes(mesh);
        const bool fits = bytes <= memory_->available_bytes();  // Advice costs time.
        memory_->charge(bytes, fmt::format("surface {}", job.surface),
                        fits ? std::string() : memory_advice(job, job.next_slab));
    } catch (const OutOfLocalMemory&) {
        mesh = SlabMesh{};  // Not charged for.
        throw;
    }
}

/// The surfaces' bytes on all GPs, as far as this one can tell from its slabs.
std::string GpNode::memory_advice(const Extract& job, std::size_t slabs_done) const {
    std::size_t all = 0;
    for (const auto& [number, held] : surfaces_) {
        const std::size_t here = mesh_bytes(held);
        all += number == job.surface ? here * held.slabs.size() / slabs_done : here;
    }
    return gp_count_advice(store_->shape(), memory_->size_bytes(),
                           all * static_cast<std::size_t>(machine_->share.gp_count));
}

void GpNode::drop_surface(std::uint16_t surface) {
    const auto held = surfaces_.find(surface);
    memory_->release(mesh_bytes(held->second));
    surfaces_.erase(held);
}

bool GpNode::step(Remove& job, bus::Outbox&) {
    // One that is not held did not fit: the host knows.
    if (surfaces_.contains(job.surface)) {
        drop_surface(job.surface);
    }
    return true;
}

/// Throws NodeFault if it cannot be handed over, or not in one message.
const HeldSurface& GpNode::surface_to_fetch(std::uint16_t surface) const {
    if (scene_) {
        throw NodeFault(FaultCode::bad_input,
                        fmt::format("surface {} is to be fetched, but belongs to a scene: it is "
                                    "no mesh",
                                    surface));
    }
    const auto held = surfaces_.find(surface);
    if (held == surfaces_.end() || !held->second.complete) {
        throw NodeFault(FaultCode::bad_input,
                        fmt::format("surface {} is to be fetched, but is not held{}", surface,
                                    held == surfaces_.end() ? "" : " whole"));
    }
    return held->second;
}

bool GpNode::step(Fetch& job, bus::Outbox& out) {
    const HeldSurface& surface = surface_to_fetch(job.surface);
    if (!job.part) {
        job.part = std::make_unique<MeshPartBuilder>(job.surface, surface, job.origins);
    } else if (job.next_slab < surface.slabs.size()) {
        const SlabMesh& mesh = surface.slabs[job.next_slab++];
        job.part->add(mesh, job.origins ? origins_of(surface, mesh) : std::span<const Origin>());
    } else {
        out.send(job.to, job.part->finish());
        return true;
    }
    return false;
}

/// Where a slab's triangles come from, extracted again if that is not kept.
std::span<const Origin> GpNode::origins_of(const HeldSurface& surface, const SlabMesh& mesh) {
    if (!machine_->origins) {
        extract_slab(*store_, mesh.slab, surface.isovalue, case_table(surface.rule), scratch_,
                     true);
        assert(scratch_.indices == mesh.indices);
        return scratch_.origins;
    }
    return mesh.origins;
}

bool GpNode::step(Mask& job, bus::Outbox& out) {
    const auto& mask = *job.message.as<schema::MaskSurface>();
    take_mask(mask);
    schema::SurfaceBuiltT built;
    built.surface = mask.surface();
    built.revision = mask.revision();
    built.memory_bytes = memory_->used_bytes();
    out.send(bus::host_id, bus::pack(built));
    return true;
}

/// A mask of a revision that is not held any more, or was never asked for, hides nothing.
void GpNode::take_mask(const schema::MaskSurface& mask) {
    const auto held = surfaces_.find(mask.surface());
    if (held == surfaces_.end() || held->second.revision != mask.revision() ||
        !held->second.complete) {
        return;
    }
    HeldSurface& surface = held->second;
    std::vector<std::vector<std::uint8_t>> hidden(surface.slabs.size());
    for (const schema::SlabMask* slab : *mask.slabs()) {
        const auto mesh = std::ranges::lower_bound(surface.slabs, static_cast<int>(slab->slab()),
                                                   {}, &SlabMesh::slab);
        if (mesh == surface.slabs.end() || mesh->slab != static_cast<int>(slab->slab())) {
            continue;  // Another GP's.
        }
        const std::size_t triangles = mesh->indices.size() / 3, bytes = slab->hidden()->size();
        if (bytes != (triangles + 7) / 8) {
            throw NodeFault(
                FaultCode::bad_input,
                fmt::format("the mask of surface {}, slab {}, has {} bytes; its {} "
                            "triangles need {}",
                            mask.surface(), slab->slab(), bytes, triangles, (triangles + 7) / 8));
        }
        hidden[static_cast<std::size_t>(mesh - surface.slabs.begin())].assign(
            slab->hidden()->begin(), slab->hidden()->end());
    }
    surface.hidden = std::move(hidden);
}

/// A newer request takes the place of one that is not answered yet.
void GpNode::note_measure(const bus::Message& message) {
    const auto& measure = *message.as<schema::MeasureIsovalues>();
    measuring_.reset();
    if (!store_) {
        throw NodeFault(FaultCode::bad_input,
                        fmt::format("{} isovalues are to be measured, but no volume is held",
                                    measure.isovalues()->size()));
    }
    measuring_ = Measure{{measure.isovalues()->begin(), measure.isovalues()->end()},
                         static_cast<CaseRule>(measure.table()),
                         message.source(),
                         {}};
}

bool GpNode::step(Measure& job, bus::Outbox& out) {
    const bus::StageClock::In measuring(out.clock(), stage::measure);
    if (!store_->complete()) {
        throw NodeFault(FaultCode::bad_input,
                        fmt::format("{} isovalues are to be measured before all slices of volume "
                                    "{} came",
                                    job.isovalues.size(), *volume_));
    }
    const std::size_t all = store_->slabs().size() * job.isovalues.size();
    for (std::size_t spent_ns = 0; job.counts.size() < all && spent_ns < piece_ns;) {
        const int slab = store_->slabs()[job.counts.size() / job.isovalues.size()];
        const double isovalue = job.isovalues[job.counts.size() % job.isovalues.size()];
        job.counts.push_back(measure_slab(*store_, slab, isovalue, case_table(job.rule), scratch_));
        spent_ns += cost_ns(store_->shape(), job.counts.back());
    }
    if (job.counts.size() < all) {
        return false;
    }
    out.send(job.to, isovalues_measured_message(store_->slabs(), job.counts));
    return true;
}

}  // namespace pxpl5::gp
