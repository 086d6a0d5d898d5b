// The voxel service: sends values of voxels.
#pragma once

#include "gp_firmware/node/job_queue.hpp"
#include "ringbus/node.hpp"

namespace pxpl5::gp {

/// Takes a question. Answers an older one that waits without slices. Throws bus::NodeFault if no
/// complete volume will have the box.
void note_voxels(const bus::Message& message, const Board& board, JobQueue& queue,
                 bus::Outbox& out);

/// Copies one slice of the box, or sends the answer. Returns true when the job is done.
bool step(VoxelsJob& job, Board& board, bus::Outbox& out);

/// Answers a job that is dropped with no slices: the host counts the answers.
void answer_dropped(const VoxelsJob& job, bus::Outbox& out);

}  // namespace pxpl5::gp
