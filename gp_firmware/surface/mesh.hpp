// The mesh of one surface in one slab: triangles from marching cubes, or primitives of a scene.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

namespace pxpl5::gp {

inline constexpr float normal_one = 32767.0F;  ///< A unit component in Vertex::normal.

struct Vertex {
    glm::vec3 p_voxel;                   ///< Grid position, in voxel units.
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
    // Extraction visits fewer cells and edges than the board did, because the board had no ranges
    // of rows and slices (host/timing/README.md has the board's rule).
    std::uint32_t cells_visited = 0;
    std::uint32_t edges_visited = 0, edges_crossed = 0;  ///< Including the upper slice.
    double area_mm2 = 0;
    double volume_mm3 = 0;  ///< Volume inside; the scan's faces close it at the border.
};

/// The provenance of a triangle. The GP keeps it while the run is recorded, so that inspection can
/// trace a pixel to its cell. The cell's k is the slab. Messages carry it as schema::Origin.
struct Origin {
    std::uint16_t i = 0, j = 0;  ///< Cell.
    std::uint8_t inside = 0;     ///< Case: bit c is set if corner c of the cell is inside.
    std::uint8_t joined = 0;     ///< Bit f: on ambiguous face f the inside corners are joined.
    std::uint8_t triangle = 0;   ///< In the case, from 0.
    std::uint8_t piece = 0;      ///< Piece of the triangle after clipping; 0 in a mesh.
    friend bool operator==(const Origin&, const Origin&) = default;
};
static_assert(sizeof(Origin) == 8);

// Primitives of a scene, in voxel units. Marching cubes does not make them.
struct Sphere {
    glm::vec3 p_voxel;
    float radius = 0;  ///< > 0.
};
struct Line {
    glm::vec3 from_voxel, to_voxel;
};

/// Lengths of a mesh's lists.
struct MeshSize {
    std::size_t vertices = 0, triangles = 0;
};

/// Slab `slab` is the layer of cells between slices slab and slab + 1.
struct SlabMesh {
    int slab = 0;
    std::vector<Vertex> vertices;
    std::vector<std::uint64_t> keys;  ///< Per vertex: 4 * voxel index + axis; axis 3 = cell center.
    std::vector<std::uint32_t> indices;  ///< 3 per triangle, counter-clockwise seen from outside.
    std::vector<Origin> origins;         ///< One per triangle; empty if not requested.
    std::vector<Sphere> spheres;         ///< Only in scenes.
    std::vector<Line> lines;             ///< Only in scenes.
    SlabCounts counts;
    /// Set if the lists did not fit into the local memory, and are empty: the GP extracts the slab
    /// again where its triangles are needed.
    std::optional<MeshSize> left_out;
};

/// Returns the size of the mesh, which may be left out.
inline MeshSize size_of(const SlabMesh& mesh) {
    return mesh.left_out.value_or(MeshSize{mesh.vertices.size(), mesh.indices.size() / 3});
}

using SlabMask = std::vector<std::uint8_t>;

/// Returns whether the mask of a slab hides a triangle: bit t % 8 of byte t / 8 hides triangle t.
/// An empty mask hides none.
inline bool is_hidden(std::span<const std::uint8_t> hidden, std::size_t triangle) {
    return !hidden.empty() && (hidden[triangle / 8] >> triangle % 8 & 1) != 0;
}

}  // namespace pxpl5::gp
