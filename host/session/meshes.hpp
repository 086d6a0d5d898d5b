// Meshes of surfaces, read back from the GPs, and masks of their triangles.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/scene/scene.hpp"
#include "host/session/volumes.hpp"
#include "host/surface/atlas/atlas_chart.hpp"
#include "host/surface/blocks/block_gather.hpp"
#include "host/surface/components.hpp"
#include "host/surface/volume_grid.hpp"
#include "host/surface/welded_mesh.hpp"

namespace pxpl5::host {

/// The components of a surface, and one of them.
struct ChosenComponent {
    MeshComponents parts;
    std::size_t number = 0;  ///< From 0, the largest.
};

/// Whether a component that is open only at the faces of the scan has a volume: they close it. One
/// with holes has none.
enum class OpenParts : std::uint8_t { without_volume, closed_by_scan };

/// The components of a surface, and which of its triangles are drawn.
struct DrawnComponents {
    MeshComponents parts;
    Shown shown;

    bool is_drawn(const MeshComponent& component) const {
        return shown[component.first_triangle] != 0;
    }
    /// Volume of the drawn components, cavities taken off. Nothing if one of them has none.
    std::optional<double> volume_ml(OpenParts open) const;
    double area_mm2() const;  ///< The area of the drawn components.
};

class Meshes {
  public:
    Meshes(Conversation& conversation, Scene& scene, const Volumes& volumes)
        : conversation_(conversation), scene_(scene), volumes_(volumes) {}

    /// The surface of that name in the scene. Throws RequestError.
    Surface& surface(const std::string& name) const;
    const Volumes& volumes() const { return volumes_; }
    VolumeGrid grid() const { return grid_of(volumes_.volume()); }

    /// The surface as one mesh. cells: with the cell of each triangle.
    WeldedMesh fetch(const std::string& name, bool cells = false);
    /// The surface's mesh without the components that are not drawn.
    WeldedMesh fetch_drawn(const Surface& surface);
    /// The surface, simplified, without the components that are not drawn. Throws RequestError
    /// (failed) if the volume's surfaces cannot be simplified.
    /// detail  1..max_detail.
    SimplifiedMesh fetch_simplified(const Surface& surface, int detail);
    /// FNV-1a over the surface's triangles in slab order: equal for every size of machine.
    std::uint64_t digest(const std::string& name);
    /// Draws only the shown triangles of `mesh`, until the surface changes.
    void show(const std::string& name, const WeldedMesh& mesh, const Shown& shown);
    /// The surface's components; its filter selects those that are drawn.
    DrawnComponents components(const Surface& surface);
    /// The component nearest to a point, patient (LPS). The surface has triangles.
    ChosenComponent component_at(const Surface& surface, glm::dvec3 p_mm);
    /// Draws only the components that the surface's filter selects.
    DrawnComponents apply_filter(const Surface& surface);
    /// For work of the host on the surface's mesh: hears signals and viewers.
    Pause pause_of(const Surface& surface);
    /// The measures of the surface at each isovalue (ascending), without components.
    std::vector<AtlasRow> measure(std::span<const double> isovalues, CaseRule table);

  private:
    /// The kind of mesh that fetch_parts() asks for.
    struct Wish {
        bool origins = false;
        int detail = 0;
    };
    /// Gives each GP's part of the surface's mesh to `take`, in any order.
    void fetch_parts(const Surface& surface, Wish wish,
                     const std::function<void(const bus::Message&)>& take);

    Conversation& conversation_;
    Scene& scene_;
    const Volumes& volumes_;
};

}  // namespace pxpl5::host
