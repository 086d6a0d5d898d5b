// A surface as one mesh in the host: the GPs' slabs put together, each vertex once.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

namespace pxpl5::host {

/// The marching-cubes cell that a triangle comes from.
struct MeshCell {
    std::uint16_t i = 0, j = 0, k = 0;  ///< Cell; k is the slab.
    std::uint8_t inside = 0;            ///< Case: bit c is set if corner c of the cell is inside.
    std::uint8_t joined = 0;  ///< Bit f: on ambiguous face f the inside corners are joined.
};

/// The triangles of one slab, as the GP numbers them.
struct SlabTriangles {
    std::uint32_t slab = 0;
    std::size_t first = 0, count = 0;  ///< Into WeldedMesh::triangles.
};

/// One surface. The same surface gives the same bytes whatever the machine: slabs ascend, vertices
/// ascend by key, triangles keep the order of their slab.
struct WeldedMesh {
    std::vector<std::uint64_t> keys;  ///< Ascending; 4 * voxel index + axis, axis 3 = cell center.
    std::vector<glm::vec3> p_grid;    ///< Per key: position in the volume's grid.
    std::vector<glm::vec3> normals;   ///< Per key: unit, out of the inside, patient axes (LPS).
    std::vector<std::array<std::uint32_t, 3>> triangles;  ///< Counter-clockwise from outside.
    std::vector<SlabTriangles> slabs;                     ///< Ascending by slab.
    std::vector<MeshCell> cells;  ///< One per triangle; empty if not requested.
};

}  // namespace pxpl5::host
