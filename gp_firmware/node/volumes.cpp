#include "gp_firmware/node/volumes.hpp"

#include <fmt/format.h>

#include <utility>

#include "gp_firmware/node/messages.hpp"
#include "gp_firmware/node/stages.hpp"
#include "ringbus/stored_volume.hpp"

namespace pxpl5::gp {

namespace {

namespace schema = bus::schema;
using bus::NodeFault;
using schema::FaultCode;

/// Throws the StoredFileError as a fault of this GP on this computer.
[[noreturn]] void rethrow_file_error(const StoredFileError& error, const Board& board) {
    throw NodeFault(FaultCode::bad_input, fmt::format("gp-{} on {}: {}", board.machine.gp_index(),
                                                      computer_name(), error.what()));
}

}  // namespace

Freed freed_for(const schema::VolumeHeader& next, const Board& board) {
    if (!board.store) {
        return Freed::returned;
    }
    const VolumeShape& now = board.store->shape();
    return std::cmp_equal(next.nx(), now.nx) && std::cmp_equal(next.ny(), now.ny) &&
                   std::cmp_equal(next.nz(), now.nz) && next.type() == now.type
               ? Freed::kept
               : Freed::returned;
}

void begin_volume(const schema::VolumeHeader& header, Board& board, JobQueue& queue) {
    board.volume = header.volume();
    board.volume_since = Clock::now();
    try {
        board.store =
            std::make_unique<SliceStore>(shape_of(header), board.machine.share, board.memory);
    } catch (const std::exception&) {
        rethrow_as_fault();
    }
    if (header.stored() == nullptr || board.store->complete()) {
        return;  // The host sends the slices, or the GP owns no slab and needs none.
    }
    queue.add(FileSlicesJob{std::make_unique<StoredSlices>(
        board.store->shape(), bus::stored_volume_of(*header.stored()))});
}

void note_slices(const bus::Message& message, const Board& board, JobQueue& queue) {
    const auto& slices = *message.as<schema::Slices>();
    if (board.volume != slices.volume()) {
        throw NodeFault(
            FaultCode::bad_input,
            fmt::format("slices of volume {} arrived, but {}", slices.volume(),
                        board.volume ? fmt::format("volume {} is the announced one", *board.volume)
                                     : "no volume was announced"));
    }
    if (board.store) {
        queue.add(SlicesJob{message});
    }
}

bool step(SlicesJob& job, Board& board, bus::Outbox& out) {
    const bus::StageClock::In loading(out.clock(), stage::load);
    const auto& slices = *job.message.as<schema::Slices>();
    const std::size_t size = slices.values()->size() / slices.slice_count();
    const std::span<const std::uint8_t> values(slices.values()->data() + job.done * size, size);
    board.store->add_slice(static_cast<int>(slices.first_slice() + job.done),
                           std::as_bytes(values));
    return ++job.done == slices.slice_count();
}

bool step(FileSlicesJob& job, Board& board, bus::Outbox& out) {
    const bus::StageClock::In loading(out.clock(), stage::load);
    const int z = board.store->next_slice();
    try {
        board.store->add_slice(z, job.file->read(z));
        if (board.store->complete()) {
            job.file->check();  // The last slices are of the same file, too.
        }
    } catch (const StoredFileError& error) {
        rethrow_file_error(error, board);
    }
    return board.store->complete();
}

bool step(VolumeEndJob&, Board& board, bus::Outbox& out) {
    if (!board.store->complete()) {
        throw NodeFault(FaultCode::bad_input,
                        fmt::format("volume {} ended, but slices are missing", *board.volume));
    }
    schema::VolumeReadyT ready = volume_ready(board);
    ready.slabs = static_cast<std::uint32_t>(board.store->slabs().size());
    const StoreCounts counts = board.store->counts();
    ready.slices = counts.slices;
    ready.rows_in_runs = counts.rows_in_runs;
    ready.runs = counts.runs;
    out.send(bus::host_id, bus::pack(ready));
    return true;
}

}  // namespace pxpl5::gp
