#include "gp_firmware/node/surfaces.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <span>
#include <utility>

#include "gp_firmware/node/messages.hpp"
#include "gp_firmware/node/stages.hpp"
#include "gp_firmware/render/surface_memory.hpp"
#include "gp_firmware/surface/cluster_block.hpp"
#include "gp_firmware/surface/marching_cubes.hpp"

namespace pxpl5::gp {

namespace {

namespace schema = bus::schema;
using bus::NodeFault;
using schema::FaultCode;

constexpr std::size_t triangles_per_piece = 50'000;  ///< About 1 ms of an extraction.

/// Estimates from the slabs of this GP how many GPs would hold all surfaces without leaving slabs
/// out. Returns 0 if the surface has none that is left out, or no number of GPs would do.
int gps_to_hold_all(const HeldSurface& surface, const Board& board) {
    if (std::ranges::none_of(surface.slabs, is_left_out)) {
        return 0;
    }
    std::size_t bytes = 0;
    for (const auto& [number, held] : board.surfaces) {
        for (const SlabMesh& mesh : held.slabs) {
            bytes += tight_bytes(mesh);
        }
    }
    const int gps = board.machine.share.gp_count;
    return gp_count_that_would_do(board.store->shape(), board.memory.size_bytes(),
                                  bytes * static_cast<std::size_t>(gps), board.store->packing(),
                                  gps + 1);
}

/// Copies a list. Keeps the capacity of `to` unless more than half of it would be unused.
template <class T>
void copy_closely(const std::vector<T>& from, std::vector<T>& to) {
    if (to.capacity() < from.size() || to.capacity() / 2 > from.size()) {
        to = std::vector<T>();  // Frees the memory, which clear() would not.
        to.reserve(from.size());
    }
    to.assign(from.begin(), from.end());
}

void copy_closely(const SlabMesh& from, SlabMesh& to) {
    to.slab = from.slab;
    to.counts = from.counts;
    to.left_out.reset();
    copy_closely(from.vertices, to.vertices);
    copy_closely(from.keys, to.keys);
    copy_closely(from.indices, to.indices);
    copy_closely(from.origins, to.origins);
}

/// Whether more than half of the mesh's capacity is unused. A few pages do not count.
bool is_roomy(const SlabMesh& mesh) {
    constexpr std::size_t spare_bytes = 4096;
    return size_bytes(mesh) > 2 * tight_bytes(mesh) + spare_bytes;
}

/// Extracts a piece of the next slab. The slab replaces that of the older revision, because the
/// memory need not have room for both.
void extract_next(ExtractJob& job, HeldSurface& surface, Board& board) {
    SlabMesh& mesh = surface.slabs[job.next_slab];
    if (!job.extraction) {
        job.extraction =
            begin_slab(*board.store, board.store->slabs()[job.next_slab], job.isovalue,
                       case_table(job.rule), board.scratch, board.machine.keeps_origins);
    }
    if (job.extraction(triangles_per_piece)) {
        return;
    }
    job.extraction = nullptr;
    board.memory.release(size_bytes(mesh));
    const bool fits_as_it_is = size_bytes(board.scratch) <= board.memory.available_bytes();
    try {
        if (board.store->shape().holds_gradients() && !is_roomy(board.scratch) && fits_as_it_is) {
            std::swap(board.scratch, mesh);  // In a small volume, time matters more than memory.
            board.scratch.left_out.reset();
        } else {
            copy_closely(board.scratch, mesh);
            fit_into_memory(surface.slabs, job.next_slab, board.surfaces, board.memory);
        }
        board.memory.charge(size_bytes(mesh), fmt::format("surface {}", job.surface));
    } catch (...) {
        mesh = SlabMesh{};  // It was not charged.
        throw;
    }
    ++job.next_slab;
}

/// Ignores a mask for another revision than the stored one.
void take_mask(const schema::MaskSurface& mask, Board& board) {
    const auto held = board.surfaces.find(mask.surface());
    if (held == board.surfaces.end() || held->second.revision != mask.revision() ||
        !held->second.complete) {
        return;
    }
    HeldSurface& surface = held->second;
    std::vector<SlabMask> hidden(surface.slabs.size());
    for (const schema::SlabMask* slab : *mask.slabs()) {
        const auto mesh = std::ranges::lower_bound(surface.slabs, static_cast<int>(slab->slab()),
                                                   {}, &SlabMesh::slab);
        if (mesh == surface.slabs.end() || mesh->slab != static_cast<int>(slab->slab())) {
            continue;  // Another GP stores this slab.
        }
        const std::size_t triangles = size_of(*mesh).triangles, bytes = slab->hidden()->size();
        if (bytes != (triangles + 7) / 8) {
            throw NodeFault(
                FaultCode::bad_input,
                fmt::format("the mask of surface {}, slab {}, has {} bytes, but its {} "
                            "triangles need {}",
                            mask.surface(), slab->slab(), bytes, triangles, (triangles + 7) / 8));
        }
        hidden[static_cast<std::size_t>(mesh - surface.slabs.begin())].assign(
            slab->hidden()->begin(), slab->hidden()->end());
    }
    surface.hidden = std::move(hidden);
    drop_simplified(surface, board.memory);
}

/// A mask that hides all triangles of a slab.
SlabMask all_hidden(const SlabMesh& mesh) {
    return SlabMask(size_of(mesh).triangles / 8 + 1, 0xFF);
}

/// Returns the masks of a block: the surface's, and full ones for slabs that are not chosen.
std::vector<SlabMask> masks_of(const HeldSurface& surface, std::size_t first, std::size_t count,
                               SlabChoice choice, std::span<const int> gap_slabs) {
    if (surface.hidden.empty() && choice == SlabChoice::all) {
        return {};
    }
    std::vector<SlabMask> masks(count);
    for (std::size_t i = 0; i < count; ++i) {
        const SlabMesh& mesh = surface.slabs[first + i];
        if (!draws_slab(choice, mesh.slab, gap_slabs)) {
            masks[i] = all_hidden(mesh);
        } else if (!surface.hidden.empty()) {
            masks[i] = surface.hidden[first + i];
        }
    }
    return masks;
}

/// Extracts a slab that is left out. The mesh stays until the next call.
const SlabMesh& extract_again(const HeldSurface& surface, const SlabMesh& mesh, Board& board,
                              bool with_origins) {
    extract_slab(*board.store, mesh.slab, surface.isovalue, case_table(surface.rule),
                 board.restored, with_origins);
    assert(board.restored.indices.size() == 3 * mesh.left_out->triangles);
    return board.restored;
}

/// Returns the meshes of a block. Those that are left out are extracted into `extracted`, which is
/// scratch and does not count as local memory.
std::span<const SlabMesh> block_meshes(const HeldSurface& surface, std::span<const SlabMesh> slabs,
                                       Board& board, std::vector<SlabMesh>& extracted) {
    if (std::ranges::none_of(slabs, is_left_out)) {
        return slabs;
    }
    for (const SlabMesh& mesh : slabs) {
        extracted.push_back(is_left_out(mesh) ? extract_again(surface, mesh, board, false) : mesh);
    }
    return extracted;
}

}  // namespace

void note_surface(const schema::SetSurface& set, const Board& board, JobQueue& queue) {
    queue.announce(set.surface(), set.revision());
    if (!board.store) {
        throw NodeFault(
            FaultCode::bad_input,
            fmt::format("surface {} was requested, but no volume is stored", set.surface()));
    }
    queue.add_extraction(
        {set.surface(), set.revision(), set.isovalue(), set.table(), Clock::now(), 0, nullptr});
}

bool step(ExtractJob& job, Board& board, bus::Outbox& out) {
    const bus::StageClock::In extracting(out.clock(), stage::extract);
    if (!board.store->complete()) {
        throw NodeFault(
            FaultCode::bad_input,
            fmt::format("surface {} was requested before all slices of volume {} arrived",
                        job.surface, *board.volume));
    }
    HeldSurface& surface = board.surfaces[job.surface];
    if (job.next_slab == 0) {
        surface.revision = job.revision;
        surface.isovalue = job.isovalue;
        surface.rule = job.rule;
        surface.complete = false;
        surface.slabs.resize(board.store->slabs().size());
        surface.hidden.clear();
        drop_simplified(surface, board.memory);
    }
    if (job.next_slab < surface.slabs.size()) {
        try {
            extract_next(job, surface, board);
        } catch (...) {
            drop_surface(board, job.surface);
            throw;
        }
    }
    if (job.next_slab < surface.slabs.size()) {
        return false;
    }
    surface.complete = true;
    out.send(bus::host_id, surface_built_message(job.surface, surface, board.memory.used_bytes(),
                                                 to_us(Clock::now() - job.since),
                                                 gps_to_hold_all(surface, board)));
    return true;
}

bool step(RemoveJob& job, Board& board, bus::Outbox&) {
    if (board.surfaces.contains(job.surface)) {
        drop_surface(board, job.surface);
    }
    return true;
}

bool step(MaskJob& job, Board& board, bus::Outbox& out) {
    const auto& mask = *job.message.as<schema::MaskSurface>();
    take_mask(mask, board);
    schema::SurfaceBuiltT built;
    built.surface = mask.surface();
    built.revision = mask.revision();
    built.memory_bytes = board.memory.used_bytes();
    out.send(bus::host_id, bus::pack(built));
    return true;
}

const SlabMesh& stored_or_extracted(const HeldSurface& surface, SlabMesh& mesh, Board& board,
                                    bool with_origins) {
    if (!mesh.left_out) {
        return mesh;
    }
    const SlabMesh& extracted = extract_again(surface, mesh, board, with_origins);
    if (tight_bytes(mesh) > board.memory.available_bytes() ||
        with_origins != board.machine.keeps_origins) {
        return extracted;
    }
    mesh = SlabMesh(extracted);
    board.memory.charge(size_bytes(mesh), "a slab that was left out");
    return mesh;
}

void require_whole_blocks(const SimplifiedWish& wish, const Board& board) {
    if (board.is_scene || !board.store) {
        throw NodeFault(FaultCode::bad_input,
                        fmt::format("detail {} of surface {} was requested, but only surfaces of "
                                    "volumes can be simplified; request detail 0",
                                    wish.detail, wish.surface));
    }
    const SlabSets sets = slab_sets(board.store->shape(), board.machine.share.gp_count);
    if (!sets.have_whole_blocks()) {
        throw NodeFault(
            FaultCode::bad_input,
            fmt::format("detail {} of surface {} was requested, but the sets of volume {} have {} "
                        "slab{} each on {} GPs, and a block of {} slabs must be in one GP; load "
                        "the volume with gp.slabs_per_set={} or a multiple, or use one GP",
                        wish.detail, wish.surface, *board.volume, sets.slabs_per_set,
                        sets.slabs_per_set == 1 ? "" : "s", sets.gp_count, block_slabs,
                        block_slabs));
    }
}

bool simplify_next(const SimplifiedWish& wish, Board& board) {
    HeldSurface& surface = board.surfaces.at(wish.surface);
    assert(surface.complete);
    const auto at = surface.simplified.try_emplace({wish.detail, wish.slabs}).first;
    SimplifiedSurface& simplified = at->second;
    const std::size_t first = simplified.slabs_done;
    if (first == surface.slabs.size()) {
        return true;
    }
    const auto in_block = [&](const SlabMesh& mesh) {
        return mesh.slab / block_slabs == surface.slabs[first].slab / block_slabs;
    };
    const auto end = std::find_if_not(surface.slabs.begin() + static_cast<std::ptrdiff_t>(first),
                                      surface.slabs.end(), in_block);
    const auto count = static_cast<std::size_t>(end - surface.slabs.begin()) - first;
    const VolumeShape& shape = board.store->shape();
    SlabMesh made;
    std::vector<SlabMesh> extracted;
    const double moved_mm = cluster_block(
        shape,
        block_meshes(surface, std::span(surface.slabs).subspan(first, count), board, extracted),
        masks_of(surface, first, count, wish.slabs, shape.gap_slabs), 1 << wish.detail, made);
    simplified.moved_mm = std::max(simplified.moved_mm, moved_mm);
    simplified.slabs_done += count;
    const SlabMesh& block = simplified.blocks.emplace_back(made);  // Without spare capacity.
    make_room(size_bytes(block), wish.detail, board.surfaces, board.memory);
    try {
        board.memory.charge(size_bytes(block), fmt::format("surface {}, simplified", wish.surface),
                            "draw the surface exactly");
    } catch (const OutOfLocalMemory&) {
        simplified.blocks.pop_back();  // The memory was not charged.
        drop(simplified, board.memory);
        surface.simplified.erase(at);
        throw;
    }
    return simplified.slabs_done == surface.slabs.size();
}

}  // namespace pxpl5::gp
