// Certifies a surface: closed, manifold, oriented, measures, defects.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host/base/reply.hpp"
#include "host/surface/pauses.hpp"
#include "host/surface/volume_grid.hpp"
#include "host/surface/welded_mesh.hpp"

namespace pxpl5::host {

inline constexpr std::size_t max_listed_defects =
    100;                                         ///< Limit per kind; all defects are counted.
inline constexpr double sliver_angle_deg = 1.0;  ///< A triangle with a smaller angle is a sliver.

enum class DefectKind : std::uint8_t {
    open_edge,           ///< One triangle, not in a face of the volume.
    overfull_edge,       ///< Three triangles or more.
    misoriented_edge,    ///< Two triangles that run along it in the same direction.
    pinched_vertex,      ///< Its triangles are not one fan.
    unused_vertex,       ///< No triangle.
    repeated_triangle,   ///< Another triangle has the same vertices.
    collapsed_triangle,  ///< A vertex twice.
};
inline constexpr std::size_t defect_kinds = 7;
std::string_view name_of(DefectKind kind);

struct Defect {
    DefectKind kind = DefectKind::open_edge;
    std::array<std::uint64_t, 3> keys{};  ///< Keys of the vertex, edge or triangle.
    int key_count = 0;
    glm::dvec3 p_mm{0};            ///< The middle of it.
    std::optional<MeshCell> cell;  ///< Cell of a triangle there, if the mesh has cells.
};

/// Integer keys decide all topology; no tolerance is involved.
struct Certificate {
    std::int64_t triangles = 0, vertices = 0, edges = 0;
    bool has_grid = true;           ///< Whether the surface lies in a volume, which has a border.
    std::int64_t collapsed = 0;     ///< Triangles of a file that have two corners at one place.
    std::int64_t components = 0;    ///< Triangles that hang together over edges.
    std::int64_t border_edges = 0;  ///< One triangle, within one of the volume's six faces.
    /// Ways around open edges off the border. Open edges that meet at a vertex bound one hole;
    /// where more than two meet, those of one face of a cell do.
    std::int64_t holes = 0;
    std::array<std::int64_t, defect_kinds> defect_counts{};  ///< By DefectKind.
    std::vector<Defect> defects;                             ///< The first of each kind.
    /// Edges off the border that triangles do not use equally often in both directions.
    std::int64_t unbalanced_edges = 0;
    std::int64_t degenerate = 0;  ///< Triangles of no area: where a vertex lies on a voxel.
    std::int64_t slivers = 0;     ///< An angle below sliver_angle_deg; degenerate ones not counted.
    double area_mm2 = 0;
    /// Volume of the inside; the volume's faces close the surface where the surface leaves the
    /// volume. Has a meaning only if has_volume(); negative if is_inside_out().
    double volume_mm3 = 0;
    BoxMm bounds_mm;

    std::int64_t count(DefectKind kind) const {
        return defect_counts[static_cast<std::size_t>(kind)];
    }
    std::int64_t euler() const { return vertices - edges + triangles; }
    /// No boundary edge at all; false without triangles.
    bool closed() const { return border_edges == 0 && closed_but_for_border(); }
    /// Every boundary edge lies in one of the volume's six faces; false without triangles.
    bool closed_but_for_border() const {
        return triangles > 0 && count(DefectKind::open_edge) == 0;
    }
    /// Each edge off the border has as many triangles in one direction as in the other, so that the
    /// surface separates inside and outside even where it is not manifold.
    bool watertight_but_for_border() const { return triangles > 0 && unbalanced_edges == 0; }
    bool watertight() const { return watertight_but_for_border() && border_edges == 0; }
    /// Two triangles at each edge, or one at the boundary; one fan at each vertex.
    bool manifold() const;
    /// The two triangles of each edge run along it in opposite directions.
    bool oriented() const { return count(DefectKind::misoriented_edge) == 0; }
    /// The triangles enclose a volume. With holes, the sum would depend on the origin.
    bool has_volume() const { return closed_but_for_border() && oriented(); }
    /// The triangles of a file face inwards. In a volume, values define the inside.
    bool is_inside_out() const { return !has_grid && has_volume() && volume_mm3 < 0; }
    /// Euler number of all components together; only closed, oriented manifolds have one.
    std::optional<std::int64_t> genus() const;
    /// Closed but for the border, manifold, oriented.
    bool good() const { return closed_but_for_border() && manifold() && oriented(); }
};

/// mesh     Indices below the number of keys (asserted).
/// Returns  The same for any order of equal triangles but for the last bits of area and volume.
Certificate certify(const WeldedMesh& mesh, const VolumeGrid& grid, const Pause& pause = {});

/// For people, in a few lines, and fields for programs.
/// name  Of the surface.
Reply certificate_reply(const Certificate& certificate, std::string_view name);

}  // namespace pxpl5::host
