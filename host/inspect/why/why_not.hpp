// Why something that is expected at a pixel is not there: a verdict, or which data it lacks.
//
// The recorded streams are asked first. A triangle that was never emitted is followed through the
// GP's own stages once more, so that the reason is exact; before that counts, the stages must give
// every recorded word of its slab.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/inspect/why/why.hpp"

namespace pxpl5::host::inspect {

/// What is expected. With none of it, any surface.
struct Expectation {
    std::optional<std::array<int, 3>> cell;
    std::optional<std::uint32_t> surface;  ///< Index in the frame's list; 0 if a cell needs one.
    std::optional<int> triangle;           ///< Of the cell.
};

/// The nearer to being seen, the earlier.
enum class Verdict : std::uint8_t {
    shown,            ///< It is there.
    overwritten,      ///< Stored, then hidden by a nearer one.
    lost_depth_test,  ///< A nearer one was there before.
    shut_out,         ///< It is transparent, and the pixel is one that shows what is behind.
    outside_edge,     ///< Emitted in this region; the pixel's centre lies outside.
    other_region,     ///< Emitted, but not in the pixel's region.
    left_out,         ///< Sent, but its Renderer refused the segment.
    masked,           ///< Hidden by a mask.
    clipped,
    back_face,
    no_pixel_centre,  ///< So small that it covers no pixel's centre.
    no_area,
    not_sent,      ///< Its GP sent nothing of the slab, though the slab holds it.
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
    double distance_px = 0;               ///< From the pixel's centre to that edge.
    std::uint32_t z = 0, rival_z = 0;     ///< overwritten, lost_depth_test.
    std::optional<PrimitiveFacts> rival;  ///< The triangle that hid it.
    std::vector<RegionPlace> regions;     ///< other_region: where it is.
    std::string plane;                    ///< clipped: which.
    std::optional<CellAgain> cell;        ///< not_crossed.
    std::string reason;                   ///< left_out, not_sent; unknown: what is missing.
};

struct WhyNotFinding {
    std::uint32_t frame = 0;
    int x = 0, y = 0;
    RegionPlace place;
    Expectation expected;
    TriangleVerdict verdict;  ///< Of all, the one nearest to being seen; of unknown ones, unknown.
    std::vector<TriangleVerdict> all;  ///< By triangle of the cell, or by surface.
    WhyFinding shown;                  ///< What the pixel shows instead.
};

/// Throws as PixelInquiry, and RequestError (usage) for a cell or triangle that cannot be.
WhyNotFinding why_not(FrameInquiry& frame, int x, int y, const Expectation& expected);

/// "61,40,23". Throws RequestError (usage).
std::array<int, 3> parse_cell(const std::string& text);

std::string sentence_of(const WhyNotFinding& finding, const TriangleVerdict& verdict);
Reply why_not_reply(const WhyNotFinding& finding);

/// The stages' verdict on a triangle that is in no recorded stream, or of which `emitted` pieces
/// are, none of them at the pixel: then nothing, unless the rest was clipped away.
///
/// Parts of why_not().
std::optional<TriangleVerdict> verdict_of_stages(PixelInquiry& inquiry, const TriangleName& name,
                                                 bool emitted);
/// How many triangles the cell has; an unknown or not_crossed verdict if that cannot be told.
struct CellCount {
    int triangles = 0;
    std::optional<TriangleVerdict> verdict;
};
CellCount triangles_of_cell(PixelInquiry& inquiry, const TriangleName& first);
/// The verdict on a surface of which no emitted triangle covers the pixel.
TriangleVerdict verdict_of_surface(PixelInquiry& inquiry, std::uint32_t surface);
/// The edge of a primitive that is a triangle which the pixel is farthest outside of.
TriangleVerdict farthest_edge(const PixelInquiry& inquiry, const Primitive& primitive);

}  // namespace pxpl5::host::inspect
