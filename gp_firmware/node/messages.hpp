// Conversions between the ring's messages and the stages' plain data.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "gp_firmware/render/frame_drawing.hpp"
#include "gp_firmware/volume/slice.hpp"
#include "ringbus/node.hpp"

namespace pxpl5::gp {

/// Throws the exception that a stage has thrown as a NodeFault. Call it inside a catch block.
/// cause  The request that failed; empty while the node receives it, because the driver knows it.
[[noreturn]] void rethrow_as_fault(const bus::FaultCause& cause = {});

/// Returns a duration in the unit of messages.
std::uint64_t to_us(std::chrono::steady_clock::duration elapsed);

VolumeShape shape_of(const bus::schema::VolumeHeader& header);

SlicePlane slice_plane_of(const bus::schema::SlicePlane& plane);

/// Returns the request without the assignment.
/// shape  The volume's shape; default-constructed without a volume.
FrameRequest frame_request(const bus::schema::DrawFrame& draw, const VolumeShape& shape);

/// Returns the costs of the previous frame's regions; may be empty.
std::span<const std::uint64_t> costs_of(const bus::schema::DrawFrame& draw);

bus::Payload begin_frame_message(const bus::schema::DrawFrame& draw,
                                 const std::vector<std::uint16_t>& assignment);

/// Writes origins into a message.
flatbuffers::Offset<flatbuffers::Vector<const bus::schema::Origin*>> origins_to_wire(
    flatbuffers::FlatBufferBuilder& builder, std::span<const Origin> origins);

/// Returns the primitives of a scene part.
SlabMesh slab_mesh_of(const bus::schema::ScenePart& part);

/// gps_to_hold_all  See SurfaceBuilt; 0 if no slab is left out.
bus::Payload surface_built_message(std::uint16_t surface, const HeldSurface& held,
                                   std::size_t memory_bytes, std::uint64_t elapsed_us,
                                   int gps_to_hold_all);

/// drawing  A frame that is drawn completely.
bus::Payload frame_counts_message(std::uint32_t frame, const FrameDrawing& drawing);

/// slabs   An ascending list.
/// counts  The counts of the first slab for all isovalues, then of the next slab.
bus::Payload isovalues_measured_message(const std::vector<int>& slabs,
                                        std::span<const SlabCounts> counts);

}  // namespace pxpl5::gp
