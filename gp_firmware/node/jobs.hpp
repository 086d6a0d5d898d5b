// Jobs: the work that messages have asked for. A service does a job in pieces. `asked_by` is the
// kind of message that asks for such a job.
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
#include "gp_firmware/volume/stored_slices.hpp"
#include "ringbus/message.hpp"

namespace pxpl5::gp {

/// Stores the slices of a Slices message.
struct SlicesJob {
    static constexpr bus::Body asked_by = bus::Body::Slices;
    bus::Message message;
    std::uint32_t done = 0;  ///< Slices of the message that are stored.
};

/// Reads the slices of the volume from its file.
struct FileSlicesJob {
    static constexpr bus::Body asked_by = bus::Body::VolumeHeader;
    std::unique_ptr<StoredSlices> file;
};

/// Reports that the volume is complete.
struct VolumeEndJob {
    static constexpr bus::Body asked_by = bus::Body::VolumeEnd;
};

/// Stores a part of a scene.
struct ScenePartJob {
    static constexpr bus::Body asked_by = bus::Body::ScenePart;
    bus::Message message;
};

/// Reports that the scene is complete.
struct SceneEndJob {
    static constexpr bus::Body asked_by = bus::Body::SceneEnd;
};

/// Extracts one revision of a surface from all slabs of this GP.
struct ExtractJob {
    static constexpr bus::Body asked_by = bus::Body::SetSurface;
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
    static constexpr bus::Body asked_by = bus::Body::RemoveSurface;
    std::uint16_t surface = 0;
};

/// Sends the mesh of a surface.
struct FetchJob {
    static constexpr bus::Body asked_by = bus::Body::FetchMesh;
    std::uint16_t surface = 0;
    bus::NodeId to = 0;
    bool origins = false;
    int detail = 0;                           ///< 0: exact.
    std::unique_ptr<MeshPartBuilder> part{};  ///< Null until the job begins.
    std::size_t next_slab = 0;
};

/// Hides triangles of a surface.
struct MaskJob {
    static constexpr bus::Body asked_by = bus::Body::MaskSurface;
    bus::Message message;
};

/// Draws a frame and sends its region programs.
struct DrawJob {
    static constexpr bus::Body asked_by = bus::Body::BeginFrame;
    enum class Stage : std::uint8_t { waiting, drawing, sending };
    FrameRequest request;
    Stage stage = Stage::waiting;
};

/// Measures the surfaces at several isovalues, slab by slab.
struct MeasureJob {
    static constexpr bus::Body asked_by = bus::Body::MeasureIsovalues;
    std::vector<double> isovalues;
    CaseRule rule = CaseRule::watertight;
    bus::NodeId to = 0;
    std::vector<SlabCounts> counts{};  ///< Done so far: all isovalues of a slab, slab after slab.
};

/// The most bytes of a box of voxels. The largest slice of a volume has as many.
inline constexpr std::uint64_t max_voxels_bytes =
    std::uint64_t{max_volume_voxels} * max_volume_voxels * sizeof(float);

/// Sends values of voxels, slice by slice: compressed slices are restored one at a time.
struct VoxelsJob {
    static constexpr bus::Body asked_by = bus::Body::FetchVoxels;
    std::uint32_t volume = 0;
    bus::schema::VoxelBox box;
    bus::NodeId to = 0;
    std::vector<std::uint32_t> slices{};  ///< Slices that the GP answers for, ascending.
    std::vector<std::uint8_t> values{};   ///< Values of the slices that are copied.
    std::size_t copied = 0;               ///< Slices so far.
};

using Job = std::variant<SlicesJob, FileSlicesJob, VolumeEndJob, ScenePartJob, SceneEndJob,
                         ExtractJob, RemoveJob, FetchJob, MaskJob, DrawJob, MeasureJob, VoxelsJob>;

}  // namespace pxpl5::gp
