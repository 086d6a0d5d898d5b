// The scene service: stores the parts of a scene as slabs of complete surfaces.
#pragma once

#include "gp_firmware/node/job_queue.hpp"
#include "ringbus/node.hpp"

namespace pxpl5::gp {

void begin_scene(const bus::schema::SceneBegin& begin, Board& board);

/// Throws bus::NodeFault if the part belongs to another scene than the announced one.
void note_part(const bus::Message& message, const Board& board, JobQueue& queue);

// Each step does a piece of a job and returns true when the job is done.
bool step(ScenePartJob& job, Board& board, bus::Outbox& out);
bool step(SceneEndJob& job, Board& board, bus::Outbox& out);

}  // namespace pxpl5::gp
