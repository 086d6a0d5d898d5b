// The surface service: extracts, removes and masks surfaces.
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

}  // namespace pxpl5::gp
