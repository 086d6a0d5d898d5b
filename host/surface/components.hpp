// A surface taken apart into what hangs together.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "host/surface/pauses.hpp"
#include "host/surface/volume_grid.hpp"
#include "host/surface/welded_mesh.hpp"

namespace pxpl5::host {

/// Triangles that hang together over edges.
struct MeshComponent {
    std::size_t first_triangle = 0;  ///< The lowest.
    std::size_t triangles = 0;
    double area_mm2 = 0;
    /// Enclosed volume. Closed component: the plain divergence sum, which is negative for a cavity.
    /// Component that is open only at the volume's border: the smaller of the two sides of the box,
    /// negative if that is the outside. Component with holes: none.
    std::optional<double> volume_mm3;
    bool closed = false;
    bool closed_but_for_border = false;  ///< All open edges lie in one of the volume's six faces.
    /// A component around which the inside of the surface lies: its volume is negative. An open
    /// one only if the solid around it has another component, because the volume of a body that
    /// fills most of the box is negative, too.
    bool cavity = false;
    /// For a cavity: the component that bounds the same solid from outside. None if the solid
    /// reaches the borders of the volume all around, or if the mesh has no grid.
    std::optional<std::uint32_t> cavity_of;
    BoxMm bounds_mm;
    glm::dvec3 center_mm{0};  ///< Center of its area.
};

struct MeshComponents {
    std::vector<MeshComponent> components;  ///< Most triangles first; of equals the lower triangle.
    std::vector<std::uint32_t> of_triangle;
    double box_mm3 = 0;  ///< The whole volume.
};

MeshComponents find_components(const WeldedMesh& mesh, const VolumeGrid& grid,
                               const Pause& pause = {});

/// Per triangle: 1 if it is shown.
using Shown = std::vector<std::uint8_t>;

/// Whether the cavities of the chosen components are shown, too. Without its cavities, a component
/// encloses a solid in which they are filled.
enum class Cavities : std::uint8_t { shown, filled };

/// The component of that number with its cavities; 0 is the largest. Throws RequestError naming
/// how many there are.
Shown show_component(const MeshComponents& parts, std::size_t component,
                     Cavities cavities = Cavities::shown);
/// The number of the largest component that is no cavity of another component. The mesh has
/// components (asserted).
std::size_t largest_component(const MeshComponents& parts);

enum class ComponentMeasure : std::uint8_t { triangles, area_mm2, volume_ml };
/// The components of at least `least` with their cavities. Volumes count without their sign, and
/// components with holes have none. A cavity of a component is never chosen for itself.
Shown show_at_least(const MeshComponents& parts, ComponentMeasure measure, double least,
                    Cavities cavities = Cavities::shown);

/// The point of triangle a, b, c that is nearest to p.
/// Source  Ericson, Real-Time Collision Detection, 5.1.5.
glm::dvec3 nearest_of_triangle(glm::dvec3 p, glm::dvec3 a, glm::dvec3 b, glm::dvec3 c);

/// A point of the surface.
struct SurfacePoint {
    std::size_t triangle = 0;
    glm::dvec3 p_mm{0};
    double distance_mm = 0;
};
/// The surface's point that is nearest; of equals that of the lowest triangle. None if the mesh is
/// empty.
std::optional<SurfacePoint> nearest_point(const WeldedMesh& mesh, const VolumeGrid& grid,
                                          glm::dvec3 p_mm);

/// The shown triangles as a mesh of their own, without vertices that none of them has. Slabs stay,
/// empty ones too.
WeldedMesh shown_part(const WeldedMesh& mesh, const Shown& shown);

}  // namespace pxpl5::host
