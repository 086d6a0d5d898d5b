// The stages of a GP, replayed for single slabs: extraction, transform and emitted words.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "gp_firmware/geometry/bin.hpp"
#include "gp_firmware/geometry/transform.hpp"
#include "gp_firmware/render/frame_drawing.hpp"
#include "gp_firmware/render/region_programs.hpp"
#include "gp_firmware/surface/case_tables.hpp"
#include "host/inspect/record/known_volume.hpp"

namespace pxpl5::host::inspect {

/// A surface as a frame shows it.
struct ShownSurface {
    std::uint32_t index = 0;  ///< In the frame's list; what streams and selections mean.
    std::uint16_t id = 0;     ///< On the ring.
    std::uint32_t revision = 0;
    std::array<std::uint8_t, 3> color{};  ///< Red, green, blue.
    bool cull_back = false;
    int detail = 0;                       ///< Above 0: simplified.
    SlabChoice slabs{};                   ///< Which of them the frame draws.
    std::uint32_t opacity = 0;            ///< Sixteenths.
    std::uint32_t rim = 0;                ///< Sixteenths.
    std::optional<double> isovalue;       ///< Nothing if its SetSurface is not recorded.
    CaseRule rule{};                      ///< If the isovalue is known.
    std::optional<gp::SlicePlane> plane;  ///< Set for a slice of the volume; then no isovalue.
    /// By slab, which of its triangles a mask hides, as of MaskSurface.
    std::map<int, std::vector<std::uint8_t>> hidden;
};
std::vector<ShownSurface> surfaces_of(const RecordedRun& run, const RecordedFrame& frame);

/// The triangle of a cell: slab k, and what the GPs' side tables say.
struct TriangleName {
    std::uint32_t surface = 0;  ///< Index in the frame's list.
    int i = 0, j = 0, k = 0;
    int triangle = 0;
    friend bool operator==(const TriangleName&, const TriangleName&) = default;
};

/// One slab of one surface: the triangles, and their corners on the screen of one view.
struct ReplayedSlab {
    gp::SlabMesh mesh;  ///< With provenance.
    std::vector<gp::ScreenVertex> screen;
};

/// The values of a cell, which determine its triangles.
struct ReplayedCell {
    std::array<double, 8> values{};  ///< By corner, see gp_firmware/surface/case_tables.hpp.
    std::uint8_t inside = 0;
    bool crossed() const { return inside != 0 && inside != 0xFF; }
};

/// Extracts one slab, whose slices, and those that its gradients need, KnownVolume::need() has
/// granted; see slices_below and slices_above.
gp::SlabMesh replay_extraction(const KnownVolume& volume, int k, double isovalue, CaseRule rule);

/// Slices on either side of a slab's lower one that its extraction looks at.
inline constexpr int slices_below = 1, slices_above = 2;

class ReplayedGp {
  public:
    /// All outlive it. The volume has a shape.
    ReplayedGp(const RecordedFrame& frame, const std::vector<ShownSurface>& surfaces,
               KnownVolume& volume);

    /// Empty if slab k of the surface can be extracted, else the missing data.
    std::string missing(std::uint32_t surface, int k);

    // For slabs of which nothing is missing.
    const ReplayedSlab& slab(std::uint32_t surface, int k, int view);
    /// Whether the frame draws slab k of the surface.
    bool draws(std::uint32_t surface, int k) const;
    /// The mask of slab k, see gp::SurfaceStyle::hidden.
    std::span<const std::uint8_t> hidden(std::uint32_t surface, int k);
    /// Every emitted word of the slab, by region, with provenance; none of a slab that is not
    /// drawn.
    const gp::RegionPrograms& programs(std::uint32_t surface, int k);
    /// Whether the recorded streams hold just those words in every region that is recorded.
    /// Returns  Empty, or a sentence that names the first region where they differ.
    std::string difference(std::uint32_t surface, int k);
    ReplayedCell cell(std::uint32_t surface, int i, int j, int k) const;

    const gp::Projection& projection(int view) const { return projections_.at(index_of(view)); }
    const gp::Camera& camera(int view) const { return cameras_.at(index_of(view)); }
    gp::RegionGrid grid(int view) const;
    KnownVolume& volume() { return volume_; }

  private:
    static std::size_t index_of(int view) { return static_cast<std::size_t>(view); }
    const gp::SlabMesh& mesh(std::uint32_t surface, int k);

    const RecordedFrame& frame_;
    const std::vector<ShownSurface>& surfaces_;
    KnownVolume& volume_;
    std::vector<gp::Camera> cameras_;
    std::vector<gp::Projection> projections_;
    using Slab = std::pair<std::uint32_t, int>;
    std::map<Slab, gp::SlabMesh> meshes_;
    std::map<std::pair<Slab, int>, ReplayedSlab> slabs_;
    std::map<Slab, gp::RegionPrograms> programs_;
};

}  // namespace pxpl5::host::inspect
