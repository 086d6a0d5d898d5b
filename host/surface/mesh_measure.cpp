#include "host/surface/mesh_measure.hpp"

#include <cmath>
#include <glm/glm.hpp>

namespace pxpl5::host {

void VolumeSums::add(const VolumeSums& other) {
    flux += other.flux;
    border += other.border;
    middle_flux += other.middle_flux;
    middle_border += other.middle_border;
}

std::vector<DoubledMiddle> doubled_middles(const WeldedMesh& mesh, const VolumeGrid& grid) {
    std::vector<DoubledMiddle> middles;
    if (grid.nx == 0) {
        middles.resize(mesh.keys.size(), {1, 1, 1});  // Without a grid nothing lies in its border.
        return middles;
    }
    middles.reserve(mesh.keys.size());
    for (const std::uint64_t key : mesh.keys) {
        const EdgePlace place = edge_place(key, grid);
        DoubledMiddle& middle = middles.emplace_back();
        for (int i = 0; i < 3; ++i) {
            const auto at = static_cast<std::size_t>(i);
            const int half = place.axis == i || place.axis == 3 ? 1 : 0;
            middle[at] = static_cast<std::uint16_t>(2 * place.voxel[at] + half);
        }
    }
    return middles;
}

unsigned common_border(const DoubledMiddle& a, const DoubledMiddle& b, const VolumeGrid& grid) {
    const std::array<int, 3> last = {2 * (grid.nx - 1), 2 * (grid.ny - 1), 2 * (grid.nz - 1)};
    unsigned faces = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        if (a[i] != b[i]) continue;
        if (a[i] == 0) faces |= 1U << (2 * i);
        if (a[i] == last[i]) faces |= 2U << (2 * i);
    }
    return faces;
}

MeshMeasure::MeshMeasure(const WeldedMesh& mesh, const VolumeGrid& grid)
    : mesh_(mesh),
      grid_(grid),
      cofactors_(cofactors(grid)),
      scale_(glm::determinant(glm::dmat3(grid.voxel_to_patient))),
      middles_(doubled_middles(mesh, grid)) {}

glm::dvec3 MeshMeasure::doubled_normal_grid(std::size_t triangle) const {
    const auto& [a, b, c] = mesh_.triangles[triangle];
    const glm::dvec3 p = p_grid(a);
    return glm::cross(p_grid(b) - p, p_grid(c) - p);
}

void MeshMeasure::add_triangle(std::size_t triangle, glm::dvec3 doubled_normal_grid,
                               VolumeSums& sums) const {
    const auto& [a, b, c] = mesh_.triangles[triangle];
    sums.flux += (p_grid(a).x + p_grid(b).x + p_grid(c).x) * doubled_normal_grid.x;
    const DoubledMiddle &p = middles_[a], &q = middles_[b], &r = middles_[c];
    const double x = p[0] + q[0] + r[0];
    sums.middle_flux += x * ((q[1] - p[1]) * (r[2] - p[2]) - (q[2] - p[2]) * (r[1] - p[1]));
}

void MeshMeasure::add_border(std::uint32_t from, std::uint32_t to, VolumeSums& sums) const {
    constexpr unsigned last_x_face = 2;
    const DoubledMiddle &p = middles_[from], &q = middles_[to];
    if ((common_border(p, q, grid_) & last_x_face) == 0) return;
    // The face's inside is gone around against the triangle's direction. Arriving at the rim, the
    // way goes on upwards along it, so the inside is above; leaving it, the inside was below.
    const double bottom = grid_.place(0);
    const glm::dvec3 a = p_grid(from), b = p_grid(to);
    sums.border += (a.y + b.y) / 2 * (a.z - b.z);
    sums.middle_border += (p[1] + q[1]) * (p[2] - q[2]) / 2.0;
    const int last_y = grid_.ny - 1;
    if (p[1] == 2 * last_y) {
        sums.border -= last_y * (a.z - bottom);
        sums.middle_border -= 2.0 * last_y * p[2];
    }
    if (q[1] == 2 * last_y) {
        sums.border += last_y * (b.z - bottom);
        sums.middle_border += 2.0 * last_y * q[2];
    }
}

double MeshMeasure::plain_mm3(const VolumeSums& sums) const {
    // Triangles are wound for the patient: where the grid mirrors, they face inwards in it.
    return scale_ * sums.flux / 6;
}

bool MeshMeasure::is_cavity(const VolumeSums& sums) const {
    return scale_ * (sums.middle_flux == 0 ? sums.flux : sums.middle_flux) < 0;
}

bool MeshMeasure::is_last_voxel_inside(const VolumeSums& sums) const {
    // Crossings do not say if the rim's upper end is inside. If it is inside, exactly the whole box
    // is missing from the sums, and they are negative.
    const double last_x = grid_.nx - 1;
    return (scale_ < 0 ? -1 : 1) * (sums.middle_flux / 6 + 2 * last_x * sums.middle_border) < 0;
}

double MeshMeasure::box_mm3() const {
    const double height = grid_.place(grid_.nz - 1) - grid_.place(0);
    return std::abs(scale_) * (grid_.nx - 1) * (grid_.ny - 1) * height;
}

double MeshMeasure::within_box_mm3(const VolumeSums& sums) const {
    const double sign = scale_ < 0 ? -1 : 1;
    const double last_x = grid_.nx - 1, last_y = grid_.ny - 1;
    const double height = grid_.place(grid_.nz - 1) - grid_.place(0);
    const double lacking = is_last_voxel_inside(sums) ? last_x * last_y * height : 0;
    return std::abs(scale_) * (sign * (sums.flux / 6 + last_x * sums.border) + lacking);
}

}  // namespace pxpl5::host
