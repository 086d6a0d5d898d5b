// Between the ring's messages and the stages' plain data.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "gp_firmware/render/frame_drawing.hpp"
#include "gp_firmware/volume/slice.hpp"
#include "ringbus/message.hpp"

namespace pxpl5::gp {

/// Throws what a stage has thrown as what the bus knows: call it where an exception is caught.
[[noreturn]] void rethrow_as_fault();

/// As messages state it.
std::uint64_t to_us(std::chrono::steady_clock::duration elapsed);

VolumeShape shape_of(const bus::schema::VolumeHeader& header);

/// Everything but the assignment.
/// shape  Of the volume; as new if there is none.
FrameRequest frame_request(const bus::schema::DrawFrame& draw, const VolumeShape& shape);

/// Costs of the previous frame's regions; may be empty.
std::span<const std::uint64_t> costs_of(const bus::schema::DrawFrame& draw);

bus::Payload begin_frame_message(const bus::schema::DrawFrame& draw,
                                 const std::vector<std::uint16_t>& assignment);

/// Origins as a message has them.
flatbuffers::Offset<flatbuffers::Vector<const bus::schema::Origin*>> origins_to_wire(
    flatbuffers::FlatBufferBuilder& builder, std::span<const Origin> origins);

/// What a part of a scene holds.
SlabMesh slab_mesh_of(const bus::schema::ScenePart& part);

bus::Payload surface_built_message(std::uint16_t surface, const HeldSurface& held,
                                   std::size_t memory_bytes, std::uint64_t elapsed_us);

/// Of a frame that is drawn.
bus::Payload frame_counts_message(std::uint32_t frame, const FrameDrawing& drawing);

/// slabs   Ascending.
/// counts  Of each slab, of each isovalue.
bus::Payload isovalues_measured_message(const std::vector<int>& slabs,
                                        std::span<const SlabCounts> counts);

}  // namespace pxpl5::gp
