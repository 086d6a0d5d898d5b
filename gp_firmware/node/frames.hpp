// The frame service: draws frames; on GP 0, also begins them for all nodes.
#pragma once

#include "gp_firmware/node/job_queue.hpp"
#include "ringbus/node.hpp"

namespace pxpl5::gp {

/// Assigns the regions of a DrawFrame to Renderers and sends BeginFrame to all nodes that draw.
/// Throws bus::NodeFault for a frame that cannot be drawn, and on another GP than GP 0.
void begin_frame(const bus::Message& message, const Board& board, JobQueue& queue,
                 bus::Outbox& out);

/// Throws bus::NodeFault if the assignment does not fit the frame.
void note_frame(const bus::schema::BeginFrame& begin, const Board& board, JobQueue& queue);

/// Does a piece of the job. Returns true when the job is done.
bool step(DrawJob& job, Board& board, bus::Outbox& out);

/// Sends empty region programs to the Renderers that have none of this frame yet: a Renderer waits
/// for a message of each GP.
void send_nothing(const DrawJob& job, Board& board, bus::Outbox& out);

}  // namespace pxpl5::gp
