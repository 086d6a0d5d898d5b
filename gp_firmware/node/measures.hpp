// The measuring service: triangles, area and volume at many isovalues.
#pragma once

#include "gp_firmware/node/job_queue.hpp"
#include "ringbus/node.hpp"

namespace pxpl5::gp {

/// Replaces an unfinished measurement. Throws bus::NodeFault if no volume is stored.
void note_measure(const bus::Message& message, const Board& board, JobQueue& queue,
                  bus::Outbox& out);

/// Answers a job that is dropped with no slabs: the host counts the answers.
void answer_dropped(const MeasureJob& job, bus::Outbox& out);

/// Does a piece of the job. Returns true when the job is done.
bool step(MeasureJob& job, Board& board, bus::Outbox& out);

}  // namespace pxpl5::gp
