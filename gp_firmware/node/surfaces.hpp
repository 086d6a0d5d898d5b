// The surface service: extracts, removes, masks and simplifies surfaces. Slabs that do not fit into
// the local memory are left out, and extracted again where they are needed.
#pragma once

#include "gp_firmware/node/job_queue.hpp"
#include "ringbus/node.hpp"

namespace pxpl5::gp {

/// Throws bus::NodeFault if no volume is stored.
void note_surface(const bus::schema::SetSurface& set, const Board& board, JobQueue& queue);

// Each step does a piece of a job and returns true when the job is done.
bool step(ExtractJob& job, Board& board, bus::Outbox& out);
bool step(RemoveJob& job, Board& board, bus::Outbox& out);
bool step(MaskJob& job, Board& board, bus::Outbox& out);

/// Returns a slab of a complete surface. Extracts it if it is left out, and stores it if it fits by
/// now; else the mesh stays until the next call.
/// with_origins  An extracted mesh has origins. A stored one has them if the run is recorded.
const SlabMesh& stored_or_extracted(const HeldSurface& surface, SlabMesh& mesh, Board& board,
                                    bool with_origins);

/// A simplified surface that is wanted.
struct SimplifiedWish {
    std::uint16_t surface = 0;  ///< Complete on this GP.
    int detail = 1;             ///< 1..max_detail.
    SlabChoice slabs = SlabChoice::all;
};

/// Throws bus::NodeFault if the GP's content cannot be simplified: a scene, or a volume whose
/// blocks of slabs are spread over several GPs.
void require_whole_blocks(const SimplifiedWish& wish, const Board& board);

/// Makes one block, unless all are made. Returns true when all are made. Charges the block to the
/// local memory. Throws OutOfLocalMemory, after it has dropped this simplified surface.
bool simplify_next(const SimplifiedWish& wish, Board& board);

}  // namespace pxpl5::gp
