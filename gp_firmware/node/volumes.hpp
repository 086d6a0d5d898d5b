// The volume service: stores the slices of a volume.
#pragma once

#include "gp_firmware/node/job_queue.hpp"
#include "ringbus/node.hpp"

namespace pxpl5::gp {

/// Returns what becomes of the content's memory if a volume with this header follows: it is kept
/// for a volume of the same size, as in a time series, because returning it costs more than storing
/// the volume.
Freed freed_for(const bus::schema::VolumeHeader& next, const Board& board);

/// Reads the slices itself if the header names their file. Throws bus::NodeFault if this GP's part
/// of the volume does not fit into the memory, or if the file is not the stated one here.
void begin_volume(const bus::schema::VolumeHeader& header, Board& board, JobQueue& queue);

/// Throws bus::NodeFault if the slices belong to another volume than the announced one.
void note_slices(const bus::Message& message, const Board& board, JobQueue& queue);

// Each step does a piece of a job and returns true when the job is done.
bool step(SlicesJob& job, Board& board, bus::Outbox& out);
bool step(FileSlicesJob& job, Board& board, bus::Outbox& out);
bool step(VolumeEndJob& job, Board& board, bus::Outbox& out);

}  // namespace pxpl5::gp
