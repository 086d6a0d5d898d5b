// Board: one GP's place in the machine, its memory and what the memory stores.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "gp_firmware/hal/local_memory.hpp"
#include "gp_firmware/node/programs_messages.hpp"
#include "gp_firmware/render/frame_drawing.hpp"
#include "gp_firmware/slices/slice_plane.hpp"
#include "gp_firmware/surface/mesh.hpp"
#include "gp_firmware/volume/share.hpp"
#include "gp_firmware/volume/slice_store.hpp"
#include "ringbus/message.hpp"

namespace pxpl5::gp {

using Clock = std::chrono::steady_clock;

/// The part of a Topology that concerns one GP.
struct Machine {
    Share share;
    std::vector<bus::NodeId> gps, renderers, frame_buffers;  ///< Node ids, by index.
    std::size_t memory_bytes = 0;
    bool keeps_origins = false;  ///< The run is recorded, so each triangle keeps its origin.

    std::uint16_t gp_index() const { return static_cast<std::uint16_t>(share.gp_index); }
};

/// Throws bus::NodeFault if the receiver is not a GP of the topology, or if there are more than
/// max_nodes_per_role GPs.
Machine machine_of(const bus::Message& topology);

/// The frame of the job in front. The buffers stay from frame to frame.
struct FrameOutput {
    FrameDrawing drawing;
    ProgramsMessages programs;     ///< The messages of `drawing`.
    std::uint64_t sent_count = 0;  ///< Frames sent so far.
};

/// The data that all services of the node work on.
struct Board {
    explicit Board(Machine of_topology)
        : machine(std::move(of_topology)), memory(machine.memory_bytes) {}
    Board(const Board&) = delete;
    Board& operator=(const Board&) = delete;

    const Machine machine;
    LocalMemory memory;
    std::optional<std::uint32_t> volume;  ///< Number of the announced volume or scene.
    Clock::time_point volume_since;       ///< When it was announced.
    std::unique_ptr<SliceStore> store;    ///< Null for a scene, and if the volume does not fit.
    bool is_scene = false;                ///< `volume` is the number of a scene.
    Surfaces surfaces;
    SlabMesh scratch;   ///< Grows during extraction, so that the stored meshes need not.
    SlabMesh restored;  ///< The slab that stored_or_extracted() returned last.
    SlicePlanes planes;
    FrameOutput frame;
};

/// Discards a stored surface.
void drop_surface(Board& board, std::uint16_t surface);

/// The use of the memory of discarded content.
enum class Freed : std::uint8_t {
    returned,  ///< The system gets it: the next content may need little.
    kept       ///< The process keeps it for content of the same size.
};

/// Discards slices, surfaces and working memory. The number of the volume stays.
void drop_content(Board& board, Freed freed);

/// Returns a VolumeReady with the fields that volumes and scenes share.
bus::schema::VolumeReadyT volume_ready(const Board& board);

}  // namespace pxpl5::gp
