// The isosurfaces of the scene, which the GPs extract.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/base/spread.hpp"
#include "host/session/frames.hpp"
#include "host/session/meshes.hpp"
#include "host/surface/compare.hpp"

namespace pxpl5::host {

/// The GPs' reports of one extraction, summed over slabs in slab order.
struct SurfaceReport {
    std::int64_t triangles = 0, vertices = 0;
    std::int64_t cells_active = 0, cells_ambiguous = 0, rows_skipped = 0;
    double area_mm2 = 0;
    double volume_mm3 = 0;             ///< Enclosed; the volume's faces close it.
    double elapsed_ms = 0;             ///< Command to the last GP's acknowledgement.
    std::int64_t memory_bytes = 0;     ///< In use over all GPs afterwards.
    std::int64_t slabs_left_out = 0;   ///< The GPs extract them again for each picture.
    std::int64_t gps_to_hold_all = 0;  ///< GPs that would leave out none, about; 0: none would.
    std::vector<bus::schema::SlabCounts> slabs{};  ///< Ascending.
};

struct SweepReport {
    int changes = 0;
    Spread extraction_ms;  ///< See SurfaceReport::elapsed_ms.
    Spread picture_ms;     ///< Change of the isovalue to the picture that shows it.
};

class Surfaces {
  public:
    Surfaces(Conversation& conversation, Scene& scene, Volumes& volumes, Meshes& meshes,
             Frames& frames)
        : conversation_(conversation),
          scene_(scene),
          volumes_(volumes),
          meshes_(meshes),
          frames_(frames) {}

    /// Adds the surface, or gives it a new isovalue, and extracts it on all GPs. Requests the
    /// announced frame (Frames::announce) at the same time: a GP draws its part as soon as it has
    /// extracted it. If the surface cannot be extracted, the surface of before is put back, or
    /// removed if there was none.
    SurfaceReport set(const std::string& name, double isovalue, CaseRule table, Color color);
    void remove(const std::string& name);
    /// The surface of that name, if it exists.
    std::optional<Surface> find(const std::string& name) const;
    /// Sets color, visible, opacity, rim and cull_back of the surface with the same name.
    void set_style(const Surface& like);
    bool has_report(const std::string& name) const { return reports_.contains(name); }
    const SurfaceReport& report_of(const std::string& name) const;
    /// Forgets all reports, because the volume is replaced.
    void forget_reports() { reports_.clear(); }

    /// Draws only these components, also after the isovalue changes. Cannot be canceled.
    DrawnComponents set_components(const std::string& name, const ComponentFilter& filter);
    /// Shows the cells where `watertight` and `lorensen1987` differ, as two surfaces of their own,
    /// in place of `name`. Ends with end_comparison(), or when one of the three changes.
    MeshComparison compare(const std::string& name);
    /// Returns whether a comparison existed.
    bool end_comparison(const std::string& name);

    /// Gives the surface one isovalue after the other and draws each. Gives each picture to `take`
    /// in order. Restores the surface at the end, also if `take` throws RequestError.
    using TakeChange = std::function<void(int, const Picture&, const SurfaceReport&)>;
    SweepReport sweep(const std::string& name, std::span<const double> isovalues,
                      const TakeChange& take);

  private:
    Surface& put(const std::string& name);
    void end_extraction(Surface& surface);
    void mask_again(const Surface& surface);
    void put_back(const std::string& name, const std::optional<Surface>& before);
    SurfaceReport extract(const Surface& surface);

    Conversation& conversation_;
    Scene& scene_;
    Volumes& volumes_;
    Meshes& meshes_;
    Frames& frames_;
    std::map<std::string, SurfaceReport, std::less<>> reports_;
};

}  // namespace pxpl5::host
