#include "gp_firmware/node/meshes.hpp"

#include <fmt/format.h>

#include <cassert>

#include "gp_firmware/node/messages.hpp"
#include "gp_firmware/node/stages.hpp"
#include "gp_firmware/node/surfaces.hpp"
#include "gp_firmware/surface/marching_cubes.hpp"

namespace pxpl5::gp {

namespace {

namespace schema = bus::schema;
using bus::NodeFault;
using schema::FaultCode;

/// Throws NodeFault if no complete mesh of the surface is stored.
HeldSurface& surface_to_fetch(std::uint16_t surface, Board& board) {
    if (board.is_scene) {
        throw NodeFault(FaultCode::bad_input,
                        fmt::format("the mesh of surface {} was requested, but a scene has no "
                                    "meshes",
                                    surface));
    }
    const auto held = board.surfaces.find(surface);
    if (held == board.surfaces.end() || !held->second.complete) {
        throw NodeFault(FaultCode::bad_input,
                        fmt::format("the mesh of surface {} was requested, but is not {}stored",
                                    surface, held == board.surfaces.end() ? "" : "completely "));
    }
    return held->second;
}

/// Returns the origins of a slab's triangles. If they are not kept, extracts the slab again.
std::span<const Origin> origins_of(const HeldSurface& surface, const SlabMesh& mesh, Board& board) {
    if (mesh.origins.size() < mesh.indices.size() / 3) {
        extract_slab(*board.store, mesh.slab, surface.isovalue, case_table(surface.rule),
                     board.scratch, true);
        assert(board.scratch.indices == mesh.indices);
        return board.scratch.origins;
    }
    return mesh.origins;
}

/// The mesh that the job asks for: of a simplified surface, the blocks that are made.
MeshToSend mesh_of(const FetchJob& job, const HeldSurface& surface) {
    MeshToSend mesh{job.surface, surface.revision, surface.slabs, job.origins, job.detail, 0};
    if (job.detail > 0) {
        const auto made = surface.simplified.find({job.detail, SlabChoice::all});
        const bool has_any = made != surface.simplified.end();
        mesh.slabs = has_any ? made->second.blocks : std::span<const SlabMesh>();
        mesh.moved_mm = has_any ? made->second.moved_mm : 0;
    }
    return mesh;
}

}  // namespace

bool step(FetchJob& job, Board& board, bus::Outbox& out) {
    HeldSurface& surface = surface_to_fetch(job.surface, board);
    if (!job.part && job.detail > 0) {
        const SimplifiedWish wish{job.surface, job.detail, SlabChoice::all};
        require_whole_blocks(wish, board);
        const bus::StageClock::In simplifying(out.clock(), stage::simplify);
        if (!simplify_next(wish, board)) {
            return false;
        }
    }
    const MeshToSend all = mesh_of(job, surface);
    if (!job.part) {
        job.part = std::make_unique<MeshPartBuilder>(all);
    } else if (job.next_slab < all.slabs.size()) {
        const std::size_t slab = job.next_slab++;
        const SlabMesh& mesh =
            job.detail > 0 ? all.slabs[slab]
                           : stored_or_extracted(surface, surface.slabs[slab], board, job.origins);
        job.part->add(mesh,
                      job.origins ? origins_of(surface, mesh, board) : std::span<const Origin>());
    } else {
        out.send(job.to, job.part->finish());
        return true;
    }
    return false;
}

void answer_dropped(const FetchJob& job, const Board& board, bus::Outbox& out) {
    const auto held = board.surfaces.find(job.surface);
    if (held != board.surfaces.end()) {
        out.send(job.to, MeshPartBuilder(mesh_of(job, held->second)).finish());
    }
}

}  // namespace pxpl5::gp
