// Why a pixel has its color: its history, and the provenance of each primitive down to the voxels.
//
//   pixel --> region --> history --> primitive --> GP, message, surface --> cell --> eight voxels
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "host/base/answer.hpp"
#include "host/inspect/why/pixel_history.hpp"
#include "host/inspect/why/replayed_gp.hpp"

namespace pxpl5::host::inspect {

/// A corner of a triangle: the crossing of the surface and an edge between two voxels.
struct CornerFacts {
    bool is_center =
        false;  ///< The corner is the vertex inside the cell: it has no edge and no values.
    std::array<int, 3> voxel_0{}, voxel_1{};
    double value_0 = 0, value_1 = 0;
    double fraction = 0;  ///< Fraction of the way from voxel_0 to voxel_1.
    glm::dvec3 p_voxel{0}, p_mm{0};
};

/// The cell of a triangle. The members after `unknown` are valid only if `unknown` is empty.
struct CellFacts {
    TriangleName name;
    gp::Origin origin;
    std::string unknown;  ///< Why voxels are not known.
    std::array<double, 8> values{};
    int triangle_count = 0;  ///< Triangles of the cell.
    std::array<CornerFacts, 3> corners;
    glm::dvec3 hit_voxel{0}, hit_mm{0};  ///< Where the pixel's ray meets the triangle's plane.
    std::string doubt;  ///< How the replayed stages of the GP differ from the recording; empty if
                        ///< they agree.
};

/// The provenance of a primitive.
struct PrimitiveFacts {
    std::string address;                    ///< Address of its SETENABS.
    std::uint32_t gp = 0;                   ///< Index.
    std::size_t gp_word = 0;                ///< Its first word in the GP's stream for the region.
    std::uint64_t sequence = 0, clock = 0;  ///< In the header of RegionPrograms.
    std::uint32_t surface = 0;              ///< Index in the frame's list.
    std::uint32_t slab = 0;
    std::optional<CellFacts> cell;  ///< Empty if the provenance was not recorded.
};

struct WhyFinding {
    std::uint32_t frame = 0;
    std::uint32_t renderer = 0;
    PixelHistory history;
    std::vector<PrimitiveFacts> facts;  ///< One entry per entry of history.visits.
    std::vector<ShownSurface> surfaces;
    std::string source, values_from;  ///< Volume; empty if its header is not recorded.
    int slices = 0;

    /// Facts of the visible primitive; null for the background.
    const PrimitiveFacts* shown() const;
};

/// A frame, and everything that is known about it. Each answer makes later answers faster.
struct FrameInquiry {
    /// frame  Empty: the last complete frame, or else the last frame.
    /// held   See KnownVolume.
    /// Throws RequestError: usage if the frame does not exist, failed if the run has no frame.
    FrameInquiry(const RecordedRun& run, std::optional<std::uint32_t> frame,
                 const Volume* held = nullptr);
    FrameInquiry(const FrameInquiry&) = delete;
    FrameInquiry& operator=(const FrameInquiry&) = delete;

    const RecordedRun& run;
    RecordedFrame frame;
    std::vector<ShownSurface> surfaces;
    KnownVolume volume;
    std::optional<ReplayedGp> replayed;  ///< If the volume's header is recorded.
};

/// One pixel of a frame.
struct PixelInquiry {
    /// Throws RequestError: usage if the pixel is outside of the picture, failed if messages for
    /// its region are not recorded.
    PixelInquiry(FrameInquiry& frame, int x, int y);
    PixelInquiry(const PixelInquiry&) = delete;
    PixelInquiry& operator=(const PixelInquiry&) = delete;

    const RecordedRegion& region() const { return frame.regions.at(place.number); }
    int y_in_view() const { return y - place.view * static_cast<int>(frame.draw().height()); }
    PrimitiveFacts facts_of(const Primitive& primitive);

    const RecordedRun& run;
    const RecordedFrame& frame;
    const std::vector<ShownSurface>& surfaces;
    KnownVolume& volume;
    std::optional<ReplayedGp>& replayed;
    int x, y;
    RegionPlace place;
    PixelHistory history;
};

WhyFinding why_of(PixelInquiry& inquiry);
/// Answers for pixel (x, y) of the whole picture, views stacked. Throws as PixelInquiry.
WhyFinding why(FrameInquiry& frame, int x, int y);

/// Intersects the ray through the center of pixel (x, y) of the view with a triangle's plane.
///
/// corners  Voxel space.
/// Returns  The weights of the corners, with sum 1. No weight is negative if and only if the
///          triangle covers the center (apart from the rounding to the screen's grid).
glm::dvec3 ray_weights(const gp::Projection& projection, const std::array<glm::dvec3, 3>& corners,
                       int x, int y);

/// One sentence: what the pixel shows, and its provenance.
std::string sentence_of(const WhyFinding& finding);
/// "triangle 2 of cell (61, 40, 23)".
std::string to_text(const TriangleName& name);
/// "surface 0 (isovalue 300)".
std::string surface_text(const std::vector<ShownSurface>& surfaces, std::uint32_t index);
Answer answer_of(const TriangleName& name);
Answer answer_of(const WhyFinding& finding);

}  // namespace pxpl5::host::inspect
