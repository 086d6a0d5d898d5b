#include "gp_firmware/node/measures.hpp"

#include <fmt/format.h>

#include "gp_firmware/node/messages.hpp"
#include "gp_firmware/node/stages.hpp"
#include "gp_firmware/surface/marching_cubes.hpp"

namespace pxpl5::gp {

namespace {

namespace schema = bus::schema;
using bus::NodeFault;
using schema::FaultCode;

// Rough costs of measuring, for cutting the work into pieces of a few milliseconds.
constexpr std::size_t ns_per_crossed_cell = 40, ns_per_row = 60, cells_per_ns = 4;
constexpr std::size_t piece_ns = 8'000'000;

std::size_t cost_ns(const VolumeShape& shape, const SlabCounts& counts) {
    const auto rows = static_cast<std::size_t>(shape.ny - 1);
    const std::size_t looked_at = (rows - counts.rows_skipped) * static_cast<std::size_t>(shape.nx);
    return rows * ns_per_row + looked_at / cells_per_ns + counts.cells_active * ns_per_crossed_cell;
}

}  // namespace

void answer_dropped(const MeasureJob& job, bus::Outbox& out) {
    out.send(job.to, isovalues_measured_message({}, {}));
}

void note_measure(const bus::Message& message, const Board& board, JobQueue& queue,
                  bus::Outbox& out) {
    const auto& measure = *message.as<schema::MeasureIsovalues>();
    if (const std::optional<Job> dropped = queue.drop_measurement()) {
        answer_dropped(std::get<MeasureJob>(*dropped), out);
    }
    if (!board.store) {
        throw NodeFault(
            FaultCode::bad_input,
            fmt::format("a measurement of {} isovalues was requested, but no volume is stored",
                        measure.isovalues()->size()));
    }
    queue.set_measurement({{measure.isovalues()->begin(), measure.isovalues()->end()},
                           measure.table(),
                           message.source()});
}

bool step(MeasureJob& job, Board& board, bus::Outbox& out) {
    const bus::StageClock::In measuring(out.clock(), stage::measure);
    if (!board.store->complete()) {
        throw NodeFault(FaultCode::bad_input,
                        fmt::format("a measurement of {} isovalues was requested before all slices "
                                    "of volume {} arrived",
                                    job.isovalues.size(), *board.volume));
    }
    const std::size_t all = board.store->slabs().size() * job.isovalues.size();
    for (std::size_t spent_ns = 0; job.counts.size() < all && spent_ns < piece_ns;) {
        const int slab = board.store->slabs()[job.counts.size() / job.isovalues.size()];
        const double isovalue = job.isovalues[job.counts.size() % job.isovalues.size()];
        job.counts.push_back(
            measure_slab(*board.store, slab, isovalue, case_table(job.rule), board.scratch));
        spent_ns += cost_ns(board.store->shape(), job.counts.back());
    }
    if (job.counts.size() < all) {
        return false;
    }
    out.send(job.to, isovalues_measured_message(board.store->slabs(), job.counts));
    return true;
}

}  // namespace pxpl5::gp
