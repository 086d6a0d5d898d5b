// Transform: maps each vertex from voxel space to the screen's integer grid.
#pragma once

#include <array>
#include <cstdint>
#include <glm/mat4x4.hpp>
#include <glm/vec4.hpp>
#include <span>
#include <vector>

#include "generated/vocabulary.hpp"
#include "gp_firmware/surface/mesh.hpp"
#include "isa/contract/region_layout.hpp"
#include "isa/contract/vector_target.hpp"

namespace pxpl5::gp {

inline constexpr int subpixels = 1 << isa::region::subpixel_bits;  ///< Grid steps in a pixel.
/// Maximal distance of drawn vertices from the picture's top left corner. Edge set-up relies on it.
inline constexpr int guard_px = 16384;
inline constexpr float w_min = 1e-3F;  ///< Least w; nearer to the eye's plane is clipped.

/// One eye's view, as the host describes it.
struct Camera {
    glm::dmat4 voxel_to_eye{1.0};      ///< Voxel index to eye mm: x right, y up, looking along -z.
    glm::dmat4 projection{1.0};        ///< Eye to clip space, OpenGL convention.
    glm::dmat4 voxel_to_patient{1.0};  ///< The volume's matrix; normals are in patient axes.
    std::vector<glm::dvec4> clip_planes;  ///< Voxel space; kept where ax + by + cz + d >= 0.
    int width_px = 0, height_px = 0;
};

/// A camera in the form that transform() needs.
struct Projection {
    /// Columns of voxel -> homogeneous (x, y, z, w); x / w, y / w in 1/16 px from the top left
    /// corner, y down; z / w in depth units.
    std::array<std::array<float, 4>, 4> voxel_to_grid;
    glm::dmat4 voxel_to_grid_exact;  ///< The same, for clipping.
    glm::dmat3 patient_to_eye;       ///< A rotation, perhaps with a reflection.
    /// Columns of patient -> eye, scaled from normal_one to normal_unit.
    std::array<std::array<float, 3>, 3> normal_to_eye;
    std::vector<glm::vec4> clip_planes;
};

// Bits of ScreenVertex::outside. A vertex without any can be drawn unclipped.
enum Outside : std::uint32_t {
    outside_left = 1,
    outside_top = 2,
    outside_near = 4,
    outside_w = 8,  ///< Behind the eye; then only bits of the user's planes are also set.
    outside_right = 16,
    outside_bottom = 32,
    outside_far = 64,
    outside_user = 256,  ///< Clip plane 0; the next planes have the next bits.
};

struct ScreenVertex {
    std::int32_t x = 0, y = 0;            ///< 1/16 px from the picture's top left corner, y down.
    std::int32_t z = 0;                   ///< Depth: z_margin .. z_far - z_margin.
    std::int32_t nx = 0, ny = 0, nz = 0;  ///< Normal, eye axes; normal_unit is unit length.
    std::uint32_t outside = 0;            ///< Outside bits; if any is set, the position is invalid.
};

/// A vertex inside of all planes, packed for the inner loops: one load fetches it.
struct alignas(16) GridVertex {
    std::int32_t x = 0, y = 0, z = 0;  ///< Position; see ScreenVertex.
    std::uint32_t normal = 0;          ///< nx, ny, nz: 10 bits each, signed, nx in the lowest.
    friend bool operator==(const GridVertex&, const GridVertex&) = default;
};
static_assert(sizeof(GridVertex) == 16 && isa::region::normal_unit < 1 << 9);

/// Unpacks a vertex.
inline ScreenVertex screen_vertex(const GridVertex& v, std::uint32_t outside = 0) {
    // Shifts the component up to the sign bit and back, which extends the sign.
    const auto component = [&v](int above) {
        return static_cast<std::int32_t>(v.normal << above) >> 22;
    };
    return {v.x, v.y, v.z, component(22), component(12), component(2), outside};
}

/// Prepares `camera`. Throws std::invalid_argument, naming the value, if a matrix or plane is not
/// finite, if voxel_to_eye is not a rigid motion of patient space, or if the picture's size or the
/// number of clip planes is out of range.
Projection prepare(const Camera& camera);

/// Returns a projection that does not turn normals: those of a slice plane are gray values.
Projection with_gray_values(Projection projection);

/// Transforms vertices to the grid, in floats of one fixed operand order: the bits are the same on
/// every target.
///
/// out      Receives the vertices; as long as `vertices`.
/// outside  Receives the Outside bits; as long as `vertices`.
/// Returns  The union of all Outside bits.
std::uint32_t transform(std::span<const Vertex> vertices, const Projection& projection,
                        std::span<GridVertex> out, std::span<std::uint32_t> outside,
                        VectorTarget target = isa::process_target());

/// Calls transform() and returns the unpacked vertices.
std::vector<ScreenVertex> transformed(std::span<const Vertex> vertices,
                                      const Projection& projection);

}  // namespace pxpl5::gp
