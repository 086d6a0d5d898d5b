// The triangles of one surface in one slab, as marching cubes leaves them.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

namespace pxpl5::gp {

inline constexpr float normal_one = 32767.0F;  ///< A unit component in Vertex::normal.

struct Vertex {
    glm::vec3 p_voxel;                   ///< Voxel units.
    std::array<std::int16_t, 3> normal;  ///< Unit, out of the inside, patient axes (LPS).
    std::int16_t unused = 0;
};
static_assert(sizeof(Vertex) == 20);

/// Sums over one slab. Everything but the sizes is independent of the machine's size.
struct SlabCounts {
    std::uint32_t triangles = 0;
    std::uint32_t vertices = 0;  ///< Owned: without the upper slice's, unless this is the top slab.
    std::uint32_t cells_active = 0;
    std::uint32_t cells_ambiguous = 0;
    std::uint32_t rows_skipped = 0;
    double area_mm2 = 0;
    double volume_mm3 = 0;  ///< Of the inside, closed by the volume's faces where it leaves it.
};

/// Slab `slab` is the layer of cells between slices slab and slab + 1.
struct SlabMesh {
    int slab = 0;
    std::vector<Vertex> vertices;
    std::vector<std::uint64_t> keys;  ///< Per vertex: 4 * voxel index + axis; axis 3 = cell centre.
    std::vector<std::uint32_t> indices;  ///< 3 per triangle, counter-clockwise seen from outside.
    SlabCounts counts;
};

}  // namespace pxpl5::gp
