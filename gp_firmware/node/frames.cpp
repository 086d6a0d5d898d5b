#include "gp_firmware/node/frames.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "gp_firmware/node/messages.hpp"
#include "gp_firmware/node/stages.hpp"
#include "gp_firmware/node/surfaces.hpp"
#include "gp_firmware/render/assignment.hpp"
#include "isa/contract/sample_sums.hpp"

namespace pxpl5::gp {

namespace {

namespace schema = bus::schema;
using bus::NodeFault;
using schema::FaultCode;

/// About 2 ms of work. The node reads new messages between pieces.
constexpr std::size_t triangles_per_piece = 50'000;

FrameRequest request_of(const schema::DrawFrame& draw, const Board& board) {
    return frame_request(draw, board.store ? board.store->shape() : VolumeShape());
}

/// Returns how many regions of the frame a Renderer can draw. Throws NodeFault if all Renderers
/// together cannot draw all regions.
std::size_t max_regions_each(const schema::DrawFrame& draw, std::size_t regions,
                             std::size_t renderers) {
    const std::size_t most = isa::max_summed_regions(draw.samples());
    if ((regions + renderers - 1) / renderers > most) {
        throw NodeFault(
            FaultCode::bad_input,
            fmt::format("frame {}: {} samples of {} x {} pixels are summed in {} regions, {} "
                        "Renderers have room for {}; draw a smaller picture, fewer samples, or "
                        "with more Renderers",
                        draw.frame(), draw.samples(), draw.width(), draw.height(), regions,
                        renderers, renderers * most));
    }
    return most;
}

/// Returns an empty text if the GP has the slices of all planes of the frame, else what is wrong.
std::string missing_slices(const FrameRequest& request, const Board& board) {
    for (const SlicePlane& plane : slice_planes_of(request)) {
        const std::string wrong = board.store == nullptr ? "no volume is stored"
                                  : !board.store->complete()
                                      ? "not all slices have arrived"
                                      : plane_refusal(plane, board.store->shape());
        if (!wrong.empty()) {
            return fmt::format("frame {} shows a slice plane: {}", request.frame, wrong);
        }
    }
    return {};
}

/// Draws a piece. Returns true while more is left.
bool draw_slabs(Board& board, bus::StageClock* clock) {
    FrameDrawing& drawing = board.frame.drawing;
    const bus::StageClock::In selecting(clock, stage::select);
    const std::uint64_t before_ns = drawing.counts().transform_ns;
    const auto extract = [&](const HeldSurface& surface, SlabMesh& mesh) -> const SlabMesh& {
        const bus::StageClock::In extracting(clock, stage::extract);
        return stored_or_extracted(surface, mesh, board, board.machine.keeps_origins);
    };
    const auto piece = [&](const SlicePlane& plane, std::size_t n, int number) -> const SlabMesh* {
        const int slab = board.store->slabs()[n];
        return number < plane_pieces(plane, board.store->shape(), slab)
                   ? &board.planes.mesh(*board.store, plane, slab, number,
                                        board.machine.keeps_origins)
                   : nullptr;
    };
    const PlaneSource planes{board.store ? board.store->slabs().size() : 0,
                             board.store && board.store->is_packed(), piece};
    const bool more = drawing.draw(board.surfaces, triangles_per_piece, extract, planes);
    if (clock != nullptr) {
        clock->move(stage::select, stage::transform, drawing.counts().transform_ns - before_ns);
    }
    return more;
}

/// Makes one block of the simplified surfaces that the frame wants. Returns true when all are made.
bool simplify_surfaces(const FrameRequest& request, Board& board, bus::StageClock* clock) {
    return std::ranges::all_of(request.surfaces, [&](const SurfaceWanted& wanted) {
        if (wanted.detail == 0 || wanted.plane) {
            return true;
        }
        const SimplifiedWish wish{wanted.surface, wanted.detail, wanted.slabs};
        require_whole_blocks(wish, board);
        const bus::StageClock::In simplifying(clock, stage::simplify);
        return simplify_next(wish, board);
    });
}

bool draw_piece(DrawJob& job, Board& board, bus::Outbox& out) {
    auto& [drawing, programs, sent_count] = board.frame;
    if (job.stage == DrawJob::Stage::waiting) {
        for (const std::string& missing :
             {missing_surface(job.request, board.surfaces), missing_slices(job.request, board)}) {
            if (!missing.empty()) {
                throw NodeFault(FaultCode::bad_input, missing);
            }
        }
        if (!simplify_surfaces(job.request, board, out.clock())) {
            return false;
        }
        drawing.begin(job.request);
        job.stage = DrawJob::Stage::drawing;
    }
    if (job.stage == DrawJob::Stage::drawing) {
        if (draw_slabs(board, out.clock())) {
            return false;
        }
        if (job.request.counts) {
            out.send(bus::host_id, frame_counts_message(job.request.frame, drawing));
        }
        programs.begin(job.request, board.machine.gp_index(), board.machine.renderers.size(),
                       drawing);
        job.stage = DrawJob::Stage::sending;
    }
    const bus::StageClock::In setting_up(out.clock(), stage::set_up);
    const bool more = programs.send(drawing, triangles_per_piece, board.machine.renderers, out);
    sent_count += more ? 0 : 1;
    return !more;
}

}  // namespace

void begin_frame(const bus::Message& message, const Board& board, JobQueue& queue,
                 bus::Outbox& out) {
    const bus::StageClock::In assigning(out.clock(), stage::assign);
    if (board.machine.share.gp_index != 0) {
        throw NodeFault(FaultCode::bad_message,
                        fmt::format("DrawFrame came to GP {}; GP 0 is the Master",
                                    board.machine.share.gp_index));
    }
    if (board.machine.renderers.empty()) {
        throw NodeFault(FaultCode::bad_input, "the topology has no Renderer");
    }
    const auto& draw = *message.as<schema::DrawFrame>();
    const FrameRequest request = request_of(draw, board);
    if (!request.surfaces.empty()) {
        try {
            // Refuses an unusable camera before other nodes wait for the frame.
            std::ranges::for_each(request.views, [](const Camera& c) { prepare(c); });
        } catch (const std::exception&) {
            rethrow_as_fault();
        }
    }
    const bus::Payload begin = begin_frame_message(
        draw, assign_regions(
                  region_count(request), board.machine.renderers.size(), costs_of(draw),
                  max_regions_each(draw, region_count(request), board.machine.renderers.size())));
    for (const bus::NodeId gp : board.machine.gps) {
        if (gp != message.header().destination()) {
            out.send(gp, begin);
        }
    }
    out.send(std::span<const bus::NodeId>(board.machine.renderers), begin);
    out.send(std::span<const bus::NodeId>(board.machine.frame_buffers), begin);
    note_frame(*schema::GetMessage(begin.bytes().data())->body_as_BeginFrame(), board, queue);
}

void note_frame(const schema::BeginFrame& begin, const Board& board, JobQueue& queue) {
    FrameRequest request = request_of(*begin.draw(), board);
    request.origins = board.machine.keeps_origins;
    const auto* assignment = begin.assignment();
    request.assignment.assign(assignment->begin(), assignment->end());
    if (request.assignment.size() != region_count(request)) {
        throw NodeFault(FaultCode::bad_message,
                        fmt::format("frame {} assigns {} regions, it has {}", request.frame,
                                    request.assignment.size(), region_count(request)));
    }
    for (const std::uint16_t renderer : request.assignment) {
        if (renderer >= board.machine.renderers.size()) {
            throw NodeFault(FaultCode::bad_message,
                            fmt::format("frame {} assigns a region to Renderer {} of {}",
                                        request.frame, renderer, board.machine.renderers.size()));
        }
    }
    queue.add(DrawJob{std::move(request)});
}

bool step(DrawJob& job, Board& board, bus::Outbox& out) {
    try {
        return draw_piece(job, board, out);
    } catch (...) {
        send_nothing(job, board, out);  // The Renderers wait for a message of each GP.
        throw;
    }
}

void send_nothing(const DrawJob& job, Board& board, bus::Outbox& out) {
    const std::size_t sent =
        job.stage == DrawJob::Stage::sending ? board.frame.programs.sent_count() : 0;
    board.frame.programs.drop();
    out.send(std::span<const bus::NodeId>(board.machine.renderers).subspan(sent),
             empty_programs_message(job.request.frame, board.machine.gp_index(), {}));
}

}  // namespace pxpl5::gp
