// Frame drawing: draws the surfaces of a GP into the region programs of one frame, in pieces.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "generated/vocabulary.hpp"
#include "gp_firmware/geometry/bin.hpp"
#include "gp_firmware/geometry/transform.hpp"
#include "gp_firmware/render/draw_slab.hpp"
#include "gp_firmware/render/region_programs.hpp"
#include "gp_firmware/slices/slice_plane.hpp"
#include "gp_firmware/surface/case_tables.hpp"
#include "gp_firmware/surface/mesh.hpp"

namespace pxpl5::gp {

/// A simplified surface, as far as it is made.
struct SimplifiedSurface {
    std::vector<SlabMesh> blocks;  ///< Ascending. A block has its first slab's number.
    std::size_t slabs_done = 0;    ///< Slabs of the surface that are in the blocks.
    double moved_mm = 0;           ///< No point is farther from the exact surface.
};

/// The detail of a simplified surface, and the slabs whose triangles it has.
using SimplifiedKey = std::pair<int, SlabChoice>;

/// The slabs of one surface that this GP stores.
struct HeldSurface {
    std::uint32_t revision = 0;
    double isovalue = 0;  ///< Isovalue of this revision.
    CaseRule rule = CaseRule::watertight;
    bool complete = false;         ///< All slabs have been extracted.
    std::vector<SlabMesh> slabs;   ///< Ascending.
    std::vector<SlabMask> hidden;  ///< One mask per slab; empty if the surface has no mask.
    std::map<SimplifiedKey, SimplifiedSurface> simplified;  ///< Without hidden triangles.
};

using Surfaces = std::map<std::uint16_t, HeldSurface>;

/// A surface that a frame shows, or a slice plane. A frame may list a surface several times with
/// different slabs.
struct SurfaceWanted {
    std::uint16_t surface = 0;
    std::uint32_t revision = 0;
    bool cull_back = false;
    SlabChoice slabs = SlabChoice::all;
    int detail = 0;                     ///< 0: exact, else see SurfaceDraw.
    std::optional<SlicePlane> plane{};  ///< Then no surface is meant.
};

/// The request for one frame, the same for every GP.
struct FrameRequest {
    std::uint32_t frame = 0;
    std::vector<Camera> views;
    std::vector<SurfaceWanted> surfaces;    ///< In drawing order.
    std::vector<std::uint16_t> assignment;  ///< Renderer of each region.
    std::vector<int> gap_slabs;             ///< Slabs across missing slices, ascending.
    bool origins = false;                   ///< Programs include the origin of each primitive.
    bool counts = false;                    ///< The host wants FrameCounts.
};

/// Counts of one slab in a frame.
struct DrawnSlab {
    std::uint32_t surface = 0;  ///< Index in the frame's list.
    std::uint32_t slab = 0;
    std::uint32_t primitives =
        0;                     ///< Primitives of all views before culling, masked ones included.
    std::uint32_t culled = 0;  ///< Primitives in no region.
};

/// Returns whether `choice` includes a slab.
/// gap_slabs  An ascending list.
bool draws_slab(SlabChoice choice, int slab, std::span<const int> gap_slabs);

/// Returns the number of regions of all views.
std::size_t region_count(const FrameRequest& request);

/// Returns the slice planes of a frame.
std::vector<SlicePlane> slice_planes_of(const FrameRequest& request);

/// Returns an empty text if `surfaces` has all surfaces of `request`, else names the missing one.
std::string missing_surface(const FrameRequest& request, const Surfaces& surfaces);

/// Returns a mesh that is left out of a surface, and may store it. It stays until the next call.
using ExtractLeftOut = std::function<const SlabMesh&(const HeldSurface&, SlabMesh&)>;

/// The triangles of slice planes in the slabs of a GP.
struct PlaneSource {
    std::size_t slabs = 0;
    bool is_packed = false;  ///< Slices are restored: a slab of a plane may take a piece's time.
    /// Returns a piece of a plane in a slab, both counted from 0, or null behind the last piece. It
    /// stays until the next call.
    std::function<const SlabMesh*(const SlicePlane&, std::size_t slab, int piece)> piece{};
};

/// Draws one frame at a time; keeps its buffers from frame to frame.
class FrameDrawing {
  public:
    /// Starts a frame with empty programs for all its regions.
    /// Throws std::invalid_argument for a camera that prepare() refuses; the programs are then
    /// empty.
    void begin(const FrameRequest& request);

    /// Draws slabs until it has handled `triangle_count` triangles, a slab that was left out, or
    /// all.
    ///
    /// surfaces  Surfaces for which missing_surface() is empty, with the complete simplified
    ///           surfaces that the frame wants. They must not change until the frame is done.
    /// extract   Called for slabs that are left out; may be empty if there are none.
    /// planes    May be empty if the frame has no slice planes.
    /// Returns   true while more is left to draw.
    bool draw(Surfaces& surfaces, std::size_t triangle_count, const ExtractLeftOut& extract = {},
              const PlaneSource& planes = {});

    /// Returns the grid of the frame's views. Requires a frame with surfaces.
    const RegionGrid& grid() const { return eyes_.at(0).grid; }
    const RegionPrograms& programs() const { return programs_; }
    const DrawCounts& counts() const { return counts_; }
    /// Returns the drawn slabs that have primitives, ascending by (surface, slab).
    std::span<const DrawnSlab> drawn() const { return drawn_; }

  private:
    struct Eye {
        Projection projection;
        RegionGrid grid;
    };

    /// Draws surface next_surface_ from slab next_slab_ on. Returns true while more is left.
    bool draw_surface(HeldSurface& held, std::size_t enough, const ExtractLeftOut& extract);
    bool draw_plane(const SlicePlane& plane, std::size_t enough, const PlaneSource& planes);
    void draw_slab_or_block(const SlabMesh& mesh, const SurfaceStyle& style);
    /// Draws a part of the slab that was begun.
    void draw_part(const SlabMesh& mesh, const SurfaceStyle& style, std::span<const Eye> eyes);
    /// Returns the number of the slab's primitives that are in any region.
    std::uint32_t draw_for(const Eye& eye, const SlabMesh& mesh, const SurfaceStyle& style);

    std::vector<Eye> eyes_;
    std::vector<Eye> gray_eyes_;  ///< The same for slice planes; see with_gray_values().
    std::vector<SurfaceWanted> wanted_;
    std::vector<int> gap_slabs_;
    std::size_t next_surface_ = 0, next_slab_ = 0;
    int next_piece_ = 0;  ///< The piece of a slice plane in its slab.
    RegionPrograms programs_;
    DrawScratch scratch_;
    DrawCounts counts_;
    std::vector<DrawnSlab> drawn_;
};

}  // namespace pxpl5::gp
