// Areas and enclosed volumes of meshes in millimeters.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/surface/volume_grid.hpp"
#include "host/surface/welded_mesh.hpp"

namespace pxpl5::host {

/// Twice the place of each vertex if it were in the middle of its edge (or cell): whole numbers, by
/// key alone. A vertex lies in a face of the volume where one of them is 0 or twice the last voxel.
using DoubledMiddle = std::array<std::uint16_t, 3>;
std::vector<DoubledMiddle> doubled_middles(const WeldedMesh& mesh, const VolumeGrid& grid);

/// The volume's faces that both vertices lie in: bit 0 x low, 1 x high, 2 y low, ...
unsigned common_border(const DoubledMiddle& a, const DoubledMiddle& b, const VolumeGrid& grid);

/// Terms of the volume of a piece of surface.
struct VolumeSums {
    double flux = 0;    ///< Six times that of (x, 0, 0) through triangles, in the grid.
    double border = 0;  ///< Area of the inside on the last x face, as far as crossings tell.
    /// The same with all vertices in the middle of their edges: whole numbers below 2^53, thus
    /// exact. They tell sides where the true sums drown in rounding.
    double middle_flux = 0, middle_border = 0;

    void add(const VolumeSums& other);
};

/// Measures triangles and sums volumes: by Gauss's theorem the flux of (x, 0, 0) through the
/// surface and through the one face of the volume where that is not zero, x = nx - 1. The area of
/// the inside on that face is the integral of y dz around it: along the surface's border there, and
/// along the face's rim where y is not zero, y = ny - 1.
class MeshMeasure {
  public:
    MeshMeasure(const WeldedMesh& mesh, const VolumeGrid& grid);

    const std::vector<DoubledMiddle>& middles() const { return middles_; }
    glm::dvec3 p_grid(std::uint32_t vertex) const { return glm::dvec3(mesh_.p_grid[vertex]); }
    glm::dvec3 p_mm(std::uint32_t vertex) const { return grid_.p_mm(p_grid(vertex)); }

    /// Twice the area's normal in the grid; exactly zero where two of the vertices coincide, or all
    /// three lie on a line of voxels.
    glm::dvec3 doubled_normal_grid(std::size_t triangle) const;
    glm::dvec3 to_mm2(glm::dvec3 doubled_normal_grid) const {
        return cofactors_ * doubled_normal_grid;
    }

    void add_triangle(std::size_t triangle, glm::dvec3 doubled_normal_grid, VolumeSums& sums) const;
    /// A side of one triangle alone, in the triangle's direction; nothing unless it is in the last
    /// x face.
    void add_border(std::uint32_t from, std::uint32_t to, VolumeSums& sums) const;

    /// The plain divergence sum of a closed surface, negative if it is a cavity.
    double plain_mm3(const VolumeSums& sums) const;
    /// Whether a closed surface has the inside around it. Exact, also where volumes drown in
    /// rounding, unless the mesh has no grid.
    bool is_cavity(const VolumeSums& sums) const;
    /// Whether the last voxel of the volume is inside. Takes the sums of the whole surface, which
    /// has no holes.
    bool is_last_voxel_inside(const VolumeSums& sums) const;
    /// Box of the whole volume, between the outermost voxels' centers.
    double box_mm3() const;
    /// Volume of the inside, between 0 and the whole box; 0 without triangles.
    double within_box_mm3(const VolumeSums& sums) const;

  private:
    const WeldedMesh& mesh_;
    const VolumeGrid& grid_;
    glm::dmat3 cofactors_;
    double scale_;  ///< mm3 per unit of the grid; negative where the grid mirrors.
    std::vector<DoubledMiddle> middles_;
};

}  // namespace pxpl5::host
