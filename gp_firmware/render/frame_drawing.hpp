// Frame drawing: one frame's way through the surfaces that a GP holds, in small pieces.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "gp_firmware/geometry/bin.hpp"
#include "gp_firmware/geometry/transform.hpp"
#include "gp_firmware/render/draw_slab.hpp"
#include "gp_firmware/render/region_programs.hpp"
#include "gp_firmware/surface/case_tables.hpp"
#include "gp_firmware/surface/mesh.hpp"

namespace pxpl5::gp {

/// One surface, as far as this GP's slabs go.
struct HeldSurface {
    std::uint32_t revision = 0;
    double isovalue = 0;  ///< Of this revision, as is the rule.
    CaseRule rule = CaseRule::watertight;
    bool complete = false;        ///< All slabs have been extracted.
    std::vector<SlabMesh> slabs;  ///< Ascending.
    /// Of each slab, as SurfaceStyle::hidden; empty if the surface has no mask.
    std::vector<std::vector<std::uint8_t>> hidden;
};

using Surfaces = std::map<std::uint16_t, HeldSurface>;

/// Which of a surface's slabs a frame draws: all, or those in gaps between slices, or the others.
enum class SlabChoice : std::uint8_t { all, outside_gaps, in_gaps };

/// A surface that a frame shows; it may do so several times, with other slabs.
struct SurfaceWanted {
    std::uint16_t surface = 0;
    std::uint32_t revision = 0;
    bool cull_back = false;
    SlabChoice slabs = SlabChoice::all;
};

/// What one frame asks of every GP.
struct FrameRequest {
    std::uint32_t frame = 0;
    std::vector<Camera> views;
    std::vector<SurfaceWanted> surfaces;    ///< In the order in which they are drawn.
    std::vector<std::uint16_t> assignment;  ///< Renderer of each region.
    std::vector<int> gap_slabs;             ///< Of the volume, ascending.
    bool origins = false;                   ///< Programs tell where each primitive comes from.
    bool counts = false;                    ///< The host wants what was drawn, counted.
};

/// A slab that went through a frame.
struct DrawnSlab {
    std::uint32_t surface = 0;  ///< Index in the frame's list.
    std::uint32_t slab = 0;
    std::uint32_t primitives = 0;  ///< Over all views; before culling. Masked triangles count.
    std::uint32_t culled = 0;      ///< Of these, in no region.
};

/// Whether a slab is among those that `choice` names.
/// gap_slabs  Ascending.
bool draws_slab(SlabChoice choice, int slab, std::span<const int> gap_slabs);

/// Regions of the picture, over all views.
std::size_t region_count(const FrameRequest& request);

/// Empty if `surfaces` hold all that `request` shows, else what is missing.
std::string missing_surface(const FrameRequest& request, const Surfaces& surfaces);

/// Draws one frame at a time; keeps its buffers from frame to frame.
class FrameDrawing {
  public:
    /// Starts a frame with empty programs for all its regions.
    /// Throws std::invalid_argument for a camera that prepare() refuses; the programs are then
    /// empty.
    void begin(const FrameRequest& request);

    /// Draws slabs until `triangle_count` triangles have gone through, or all have.
    /// surfaces  missing_surface() is empty for them, and they stay the same until the frame is
    /// done. Returns   true while there is more to draw.
    bool draw(const Surfaces& surfaces, std::size_t triangle_count);

    /// Of the views of the frame. There is none without surfaces.
    const RegionGrid& grid() const { return eyes_.at(0).grid; }
    const RegionPrograms& programs() const { return programs_; }
    const DrawCounts& counts() const { return counts_; }
    /// Those so far that hold anything, in the order of drawing: ascending by (surface, slab).
    std::span<const DrawnSlab> drawn() const { return drawn_; }

  private:
    struct Eye {
        Projection projection;
        RegionGrid grid;
    };

    /// Returns how many of the slab's primitives are in any region.
    std::uint32_t draw_for(const Eye& eye, const SlabMesh& mesh, const SurfaceStyle& style);

    std::vector<Eye> eyes_;
    std::vector<SurfaceWanted> wanted_;
    std::vector<int> gap_slabs_;
    std::size_t next_surface_ = 0, next_slab_ = 0;
    RegionPrograms programs_;
    DrawScratch scratch_;
    DrawCounts counts_;
    std::vector<DrawnSlab> drawn_;
};

}  // namespace pxpl5::gp
