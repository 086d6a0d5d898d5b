// The volume service: stores the slices of a volume.
#pragma once

#include "gp_firmware/node/job_queue.hpp"
#include "ringbus/node.hpp"

namespace pxpl5::gp {

/// Throws bus::NodeFault if this GP's part of the volume does not fit into the memory.
void begin_volume(const bus::schema::VolumeHeader& header, Board& board);

/// Throws bus::NodeFault if the slices belong to another volume than the announced one.
void note_slices(const bus::Message& message, const Board& board, JobQueue& queue);

// Each step does a piece of a job and returns true when the job is done.
bool step(SlicesJob& job, Board& board, bus::Outbox& out);
bool step(VolumeEndJob& job, Board& board, bus::Outbox& out);

}  // namespace pxpl5::gp
