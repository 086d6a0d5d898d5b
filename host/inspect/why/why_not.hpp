// Why an expected triangle or surface is not visible at a pixel: a verdict, or the missing data.
//
// The recorded streams are examined first. A triangle that was never emitted is followed through
// the replayed stages of its GP, so that the reason is exact. The stages are trusted only if they
// reproduce every recorded word of the slab.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/inspect/why/why.hpp"

namespace pxpl5::host::inspect {

/// The expected surface at the pixel. Any surface if all members are empty.
struct Expectation {
    std::optional<std::array<int, 3>> cell;
    std::optional<std::uint32_t> surface;  ///< Index in the frame's list; 0 if a cell needs one.
    std::optional<int> triangle;           ///< In the cell, from 0.
};

/// Ordered from nearest to visible to farthest from visible.
enum class Verdict : std::uint8_t {
    shown,            ///< It is visible.
    overwritten,      ///< Stored, then hidden by a nearer primitive.
    lost_depth_test,  ///< A nearer primitive was stored before.
    shut_out,         ///< It is transparent, and its stipple mask hides the pixel.
    outside_edge,     ///< Emitted in this region; the center of the pixel lies outside.
    other_region,     ///< Emitted, but not in the pixel's region.
    left_out,         ///< Sent, but its Renderer refused the segment.
    masked,           ///< Hidden by a mask.
    clipped,
    back_face,
    no_pixel_center,  ///< Too small to cover the center of a pixel.
    no_area,
    not_sent,      ///< Its GP sent nothing of the slab, although the slab contains it.
    not_crossed,   ///< The surface does not pass through the cell.
    nothing,       ///< No triangle of the surface lies on the pixel's ray.
    not_in_frame,  ///< The frame does not show the surface.
    unknown,       ///< Data are missing.
};

/// The verdict on one triangle, or on one cell or surface that has none. Fields beyond the first
/// four hold for the verdicts named with them.
struct TriangleVerdict {
    Verdict verdict = Verdict::unknown;
    std::uint32_t surface = 0;
    std::optional<TriangleName> name;
    std::optional<PrimitiveFacts> facts;  ///< If it was emitted.

    int edge = -1;                        ///< outside_edge: 0..2.
    std::int64_t edge_value = 0;          ///< At the pixel; negative is outside.
    double distance_px = 0;               ///< From the center of the pixel to that edge.
    std::uint32_t z = 0, rival_z = 0;     ///< overwritten, lost_depth_test.
    std::optional<PrimitiveFacts> rival;  ///< The triangle that hid it.
    std::vector<RegionPlace> regions;     ///< other_region: where it is.
    std::string plane;                    ///< clipped: which.
    std::optional<ReplayedCell> cell;     ///< not_crossed.
    std::string reason;                   ///< left_out, not_sent; unknown: what is missing.
};

struct WhyNotFinding {
    std::uint32_t frame = 0;
    int x = 0, y = 0;
    RegionPlace place;
    Expectation expected;
    TriangleVerdict verdict;  ///< The verdict nearest to visible; unknown if it could be another.
    std::vector<TriangleVerdict> all;  ///< By triangle of the cell, or by surface.
    WhyFinding shown;                  ///< The finding for the visible surface.
};

/// Throws as PixelInquiry, and RequestError (usage) for a cell or triangle that cannot be.
WhyNotFinding why_not(FrameInquiry& frame, int x, int y, const Expectation& expected);

/// "61,40,23". Throws RequestError (usage).
std::array<int, 3> parse_cell(const std::string& text);

std::string sentence_of(const WhyNotFinding& finding, const TriangleVerdict& verdict);
Answer answer_of(const WhyNotFinding& finding);

// Parts of why_not():

/// The verdict of the replayed stages on a triangle that is in no recorded stream. If `emitted`,
/// pieces of the triangle are in the streams, but not at the pixel: the verdict is then empty
/// unless the rest of the triangle was clipped away.
std::optional<TriangleVerdict> verdict_of_stages(PixelInquiry& inquiry, const TriangleName& name,
                                                 bool emitted);
/// The number of triangles of the cell, or a verdict unknown or not_crossed.
struct CellCount {
    int triangles = 0;
    std::optional<TriangleVerdict> verdict;
};
CellCount triangles_of_cell(PixelInquiry& inquiry, const TriangleName& first);
/// The verdict on a surface of which no emitted triangle covers the pixel.
TriangleVerdict verdict_of_surface(PixelInquiry& inquiry, std::uint32_t surface);
/// The edge of a triangle from which the pixel is farthest outside.
TriangleVerdict farthest_edge(const PixelInquiry& inquiry, const Primitive& primitive);

}  // namespace pxpl5::host::inspect
