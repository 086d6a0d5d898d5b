#include "gp_firmware/node/voxels.hpp"

#include <fmt/format.h>

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace pxpl5::gp {

namespace {

namespace schema = bus::schema;
using bus::NodeFault;
using schema::FaultCode;

bool contains(const VolumeShape& shape, const schema::VoxelBox& box) {
    const auto fits = [](std::uint32_t first, std::uint32_t size, int count) {
        return std::uint64_t{first} + size <= static_cast<std::uint64_t>(count);
    };
    return fits(box.x(), box.nx(), shape.nx) && fits(box.y(), box.ny(), shape.ny) &&
           fits(box.z(), box.nz(), shape.nz);
}

std::string text_of(const schema::VoxelBox& box) {
    return fmt::format("{} x {} x {} voxels from ({}, {}, {}) on", box.nx(), box.ny(), box.nz(),
                       box.x(), box.y(), box.z());
}

/// The slices of the box that this GP answers for, ascending. The GP keeps their values.
std::vector<std::uint32_t> slices_of(const schema::VoxelBox& box, const SliceStore& store,
                                     Share share) {
    const SlabSets sets = slab_sets(store.shape(), share.gp_count);
    std::vector<std::uint32_t> slices;
    for (std::uint32_t z = box.z(); z < box.z() + box.nz(); ++z) {
        if (sets.recorder(static_cast<int>(z)) == share.gp_index) {
            slices.push_back(z);
        }
    }
    return slices;
}

/// Appends the box's part of a slice.
void append(const schema::VoxelBox& box, const VolumeShape& shape, std::span<const std::byte> slice,
            std::vector<std::uint8_t>& values) {
    const std::size_t size = size_bytes(shape.type);
    for (std::size_t y = box.y(); y < std::size_t{box.y()} + box.ny(); ++y) {
        const std::size_t first = y * static_cast<std::size_t>(shape.nx) + box.x();
        const auto row = slice.subspan(first * size, box.nx() * size);
        const auto* bytes = reinterpret_cast<const std::uint8_t*>(row.data());
        values.insert(values.end(), bytes, bytes + row.size());
    }
}

void send(const VoxelsJob& job, bus::Outbox& out) {
    flatbuffers::FlatBufferBuilder builder(job.values.size() + 1024);
    const auto slices = builder.CreateVector(job.slices);
    const auto values = builder.CreateVector(job.values);
    out.send(job.to,
             bus::finish(builder, schema::CreateVoxelValues(builder, job.volume, slices, values)));
}

}  // namespace

void answer_dropped(const VoxelsJob& job, bus::Outbox& out) {
    send({job.volume, job.box, job.to}, out);
}

void note_voxels(const bus::Message& message, const Board& board, JobQueue& queue,
                 bus::Outbox& out) {
    const auto& fetch = *message.as<schema::FetchVoxels>();
    if (const std::optional<Job> dropped = queue.drop_voxels()) {
        answer_dropped(std::get<VoxelsJob>(*dropped), out);
    }
    const std::string asked = text_of(*fetch.box());
    if (!board.store || board.volume != fetch.volume()) {
        throw NodeFault(
            FaultCode::bad_input,
            fmt::format("{} of volume {} were requested, but {} is stored", asked, fetch.volume(),
                        board.store ? fmt::format("volume {}", *board.volume) : "no volume"));
    }
    const VolumeShape& shape = board.store->shape();
    if (!contains(shape, *fetch.box())) {
        throw NodeFault(FaultCode::bad_input,
                        fmt::format("{} were requested, but the volume has {} x {} x {}", asked,
                                    shape.nx, shape.ny, shape.nz));
    }
    const std::uint64_t bytes = std::uint64_t{fetch.box()->nx()} * fetch.box()->ny() *
                                fetch.box()->nz() * size_bytes(shape.type);
    if (bytes > max_voxels_bytes) {
        throw NodeFault(FaultCode::bad_input,
                        fmt::format("{} were requested, which have {} bytes; an answer has at most "
                                    "{}, so ask for fewer",
                                    asked, bytes, max_voxels_bytes));
    }
    queue.add(VoxelsJob{fetch.volume(), *fetch.box(), message.source(),
                        slices_of(*fetch.box(), *board.store, board.machine.share)});
}

bool step(VoxelsJob& job, Board& board, bus::Outbox& out) {
    if (!board.store || !board.store->complete()) {
        throw NodeFault(FaultCode::bad_input,
                        fmt::format("{} were requested before all slices of volume {} arrived",
                                    text_of(job.box), job.volume));
    }
    if (job.copied < job.slices.size()) {
        const int z = static_cast<int>(job.slices[job.copied++]);
        append(job.box, board.store->shape(), board.store->slice(z).values, job.values);
        return false;
    }
    send(job, out);
    return true;
}

}  // namespace pxpl5::gp
