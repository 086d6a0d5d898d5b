// Why a pixel has its colour: its history, and where each primitive in it comes from, down to the
// voxels.
//
//   pixel --> region --> history --> primitive --> GP, message, surface --> cell --> eight voxels
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "host/base/reply.hpp"
#include "host/inspect/why/gp_again.hpp"
#include "host/inspect/why/pixel_history.hpp"

namespace pxpl5::host::inspect {

/// A corner of a triangle: where the surface crosses an edge between two voxels.
struct CornerFacts {
    bool is_centre = false;  ///< The cell's own vertex instead: no edge, no values.
    std::array<int, 3> voxel_0{}, voxel_1{};
    double value_0 = 0, value_1 = 0;
    double fraction = 0;  ///< Of the way from voxel_0 to voxel_1.
    glm::dvec3 p_voxel{0}, p_mm{0};
};

/// A triangle's cell. What follows `unknown` holds only if that is empty.
struct CellFacts {
    TriangleName name;
    gp::Origin origin;
    std::string unknown;  ///< Why voxels are not known.
    std::array<double, 8> values{};
    int triangle_count = 0;  ///< Of the cell.
    std::array<CornerFacts, 3> corners;
    glm::dvec3 hit_voxel{0}, hit_mm{0};  ///< Where the pixel's ray meets the triangle's plane.
    std::string doubt;  ///< How the GP's stages, run again, differ from what was recorded, if so.
};

/// Where a primitive comes from.
struct PrimitiveFacts {
    std::string address;                    ///< Of its SETENABS.
    std::uint32_t gp = 0;                   ///< Index.
    std::size_t gp_word = 0;                ///< Its first word in the GP's stream for the region.
    std::uint64_t sequence = 0, clock = 0;  ///< Of the RegionPrograms message.
    std::uint32_t surface = 0;              ///< Index in the frame's list.
    std::uint32_t slab = 0;
    std::optional<CellFacts> cell;  ///< Nothing if the origin was not recorded.
};

struct WhyFinding {
    std::uint32_t frame = 0;
    std::uint32_t renderer = 0;
    PixelHistory history;
    std::vector<PrimitiveFacts> facts;  ///< Of history.visits, one by one.
    std::vector<ShownSurface> surfaces;
    std::string source, values_from;  ///< Of the volume; empty if its header is not recorded.
    int slices = 0;

    /// Facts of the visit that the pixel shows; null for the background.
    const PrimitiveFacts* shown() const;
};

/// A frame that is asked about, and what is known with it. Answers make the next ones quicker.
struct FrameInquiry {
    /// frame  Nothing: the last one that is complete, or else the last.
    /// held   As KnownVolume's.
    /// Throws RequestError: usage for a frame that there is not; failed if there is none.
    FrameInquiry(const RecordedRun& run, std::optional<std::uint32_t> frame,
                 const Volume* held = nullptr);
    FrameInquiry(const FrameInquiry&) = delete;
    FrameInquiry& operator=(const FrameInquiry&) = delete;

    const RecordedRun& run;
    RecordedFrame frame;
    std::vector<ShownSurface> surfaces;
    KnownVolume volume;
    std::optional<GpAgain> again;  ///< If the volume's header is recorded.
};

/// One pixel of it.
struct PixelInquiry {
    /// Throws RequestError: usage for a pixel that there is not; failed if the messages for its
    /// region are not recorded, naming them.
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
    std::optional<GpAgain>& again;
    int x, y;
    RegionPlace place;
    PixelHistory history;
};

WhyFinding why_of(PixelInquiry& inquiry);
/// Answers for pixel (x, y) of the whole picture, views stacked. Throws as PixelInquiry.
WhyFinding why(FrameInquiry& frame, int x, int y);

/// Where the ray through the centre of pixel (x, y) of the view meets a triangle's plane: the
/// weights of the corners, which sum to 1. None is negative just if the triangle covers the centre
/// (but for the screen's grid).
/// corners  Voxel space.
glm::dvec3 ray_weights(const gp::Projection& projection, const std::array<glm::dvec3, 3>& corners,
                       int x, int y);

/// One sentence for people: what the pixel shows and where it comes from.
std::string sentence_of(const WhyFinding& finding);
/// "triangle 2 of cell (61, 40, 23)".
std::string to_text(const TriangleName& name);
/// "surface 0 (isovalue 300)".
std::string surface_text(const std::vector<ShownSurface>& surfaces, std::uint32_t index);
/// Text for people, fields for programs.
Reply why_reply(const WhyFinding& finding);

}  // namespace pxpl5::host::inspect
