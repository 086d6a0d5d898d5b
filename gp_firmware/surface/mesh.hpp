// What a slab holds of one surface: triangles, as marching cubes leaves them or a scene brings
// them.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
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
    // What extraction looks at here, many at a time: less than the board, which had no ranges of
    // rows and slices (host/timing/README.md has its rule).
    std::uint32_t cells_visited = 0;
    std::uint32_t edges_visited = 0, edges_crossed = 0;  ///< Those of the upper slice, too.
    double area_mm2 = 0;
    double volume_mm3 = 0;  ///< Of the inside, closed by the volume's faces where it leaves it.
};

/// Where a triangle comes from: kept while recording, for whoever asks a picture where a pixel's
/// triangle comes from. The cell's k is the slab. In a message it is a schema::Origin.
struct Origin {
    std::uint16_t i = 0, j = 0;  ///< Cell.
    std::uint8_t inside = 0;     ///< Case: bit c is set if corner c of the cell is inside.
    std::uint8_t joined = 0;     ///< Bit f: on ambiguous face f the inside corners are joined.
    std::uint8_t triangle = 0;   ///< In the case, from 0.
    std::uint8_t piece = 0;      ///< Of the triangle after clipping, from 0; in a mesh always 0.
    friend bool operator==(const Origin&, const Origin&) = default;
};
static_assert(sizeof(Origin) == 8);

/// Of a scene: primitives that marching cubes never makes. Voxel units.
struct Sphere {
    glm::vec3 p_voxel;
    float radius = 0;  ///< > 0.
};
struct Line {
    glm::vec3 from_voxel, to_voxel;
};

/// Slab `slab` is the layer of cells between slices slab and slab + 1.
struct SlabMesh {
    int slab = 0;
    std::vector<Vertex> vertices;
    std::vector<std::uint64_t> keys;  ///< Per vertex: 4 * voxel index + axis; axis 3 = cell centre.
    std::vector<std::uint32_t> indices;  ///< 3 per triangle, counter-clockwise seen from outside.
    std::vector<Origin> origins;         ///< Of each triangle; empty if nobody asked for them.
    std::vector<Sphere> spheres;         ///< Only of scenes, as are the lines.
    std::vector<Line> lines;
    SlabCounts counts;
};

}  // namespace pxpl5::gp
