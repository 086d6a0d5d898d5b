// The mesh service: sends the mesh of a surface.
#pragma once

#include "gp_firmware/node/jobs.hpp"
#include "ringbus/node.hpp"

namespace pxpl5::gp {

/// Does a piece of the job. Returns true when the job is done.
bool step(FetchJob& job, Board& board, bus::Outbox& out);

/// Answers a job that is dropped with no slabs: the host counts the answers.
void answer_dropped(const FetchJob& job, const Board& board, bus::Outbox& out);

}  // namespace pxpl5::gp
