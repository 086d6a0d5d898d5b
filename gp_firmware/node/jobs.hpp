// Jobs: the work that messages have asked for. A service does a job in pieces.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <variant>
#include <vector>

#include "gp_firmware/node/board.hpp"
#include "gp_firmware/node/mesh_part.hpp"
#include "gp_firmware/render/frame_drawing.hpp"
#include "gp_firmware/surface/case_tables.hpp"
#include "gp_firmware/surface/marching_cubes.hpp"
#include "ringbus/message.hpp"

namespace pxpl5::gp {

/// Stores the slices of a Slices message.
struct SlicesJob {
    bus::Message message;
    std::uint32_t done = 0;  ///< Slices of the message that are stored.
};

/// Reports that the volume is complete.
struct VolumeEndJob {};

/// Stores a part of a scene.
struct ScenePartJob {
    bus::Message message;
};

/// Reports that the scene is complete.
struct SceneEndJob {};

/// Extracts one revision of a surface from all slabs of this GP.
struct ExtractJob {
    std::uint16_t surface = 0;
    std::uint32_t revision = 0;
    double isovalue = 0;
    CaseRule rule = CaseRule::watertight;
    Clock::time_point since;    ///< When the revision was requested.
    std::size_t next_slab = 0;  ///< Index into the store's slabs.
    SlabExtraction extraction;  ///< Fills Board::scratch from slab next_slab; empty before.
};

/// Discards a surface.
struct RemoveJob {
    std::uint16_t surface = 0;
};

/// Sends the mesh of a surface.
struct FetchJob {
    std::uint16_t surface = 0;
    bus::NodeId to = 0;
    bool origins = false;
    std::unique_ptr<MeshPartBuilder> part{};  ///< Null until the job begins.
    std::size_t next_slab = 0;
};

/// Hides triangles of a surface.
struct MaskJob {
    bus::Message message;
};

/// Draws a frame and sends its region programs.
struct DrawJob {
    enum class Stage : std::uint8_t { waiting, drawing, sending };
    FrameRequest request;
    Stage stage = Stage::waiting;
};

/// Measures the surfaces at several isovalues, slab by slab.
struct MeasureJob {
    std::vector<double> isovalues;
    CaseRule rule = CaseRule::watertight;
    bus::NodeId to = 0;
    std::vector<SlabCounts> counts{};  ///< Done so far: all isovalues of a slab, slab after slab.
};

using Job = std::variant<SlicesJob, VolumeEndJob, ScenePartJob, SceneEndJob, ExtractJob, RemoveJob,
                         FetchJob, MaskJob, DrawJob, MeasureJob>;

}  // namespace pxpl5::gp
