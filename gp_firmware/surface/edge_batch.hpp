// Crossed edges on their way to vertices: their ends side by side, as vector code reads them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "gp_firmware/surface/edge_vertex.hpp"
#include "gp_firmware/surface/mesh.hpp"
#include "isa/contract/vector_target.hpp"

namespace pxpl5::gp {

/// What an edge of a slab is, besides its place: bits of EdgeBatch::row_and_kind.
enum EdgeKind : std::uint32_t {
    lower_end_above = 1,  ///< The edge's lower end lies in the slab's upper slice.
    upper_end_above = 2,  ///< Likewise the upper end.
    along_y = 4,
    along_z = 8,  ///< Neither: along x.
};
inline constexpr int edge_kind_bits = 4;

/// Edges of one slab that await make_vertices(). Nothing is set beyond `count`.
struct EdgeBatch {
    static constexpr std::size_t capacity = 256;
    template <class T>
    using Column = std::array<T, capacity>;

    std::size_t count = 0;
    alignas(64) Column<float> value_0{}, value_1{};  ///< Every scalar type fits exactly.
    alignas(64) Column<std::uint32_t> gradient_xy_0{}, gradient_xy_1{};  ///< x in the low half.
    alignas(64) Column<std::int32_t> gradient_z_0{}, gradient_z_1{};
    alignas(64) Column<std::uint32_t> x{};             ///< Of the lower end, voxels.
    alignas(64) Column<std::uint32_t> row_and_kind{};  ///< y << edge_kind_bits | EdgeKind.

    void set_gradients(std::size_t i, const Gradient& lower, const Gradient& upper) {
        std::memcpy(&gradient_xy_0[i], lower.data(), sizeof(std::uint32_t));
        std::memcpy(&gradient_xy_1[i], upper.data(), sizeof(std::uint32_t));
        gradient_z_0[i] = lower[2];
        gradient_z_1[i] = upper[2];
    }
};

/// What the edges of a slab have in common.
struct SlabFrame {
    double isovalue = 0;
    std::array<double, 2> places{};    ///< Of the slices in the grid, the lower first.
    double height = 1;                 ///< From the one to the other.
    std::array<float, 2> z_factors{};  ///< As of z_factor().
    NormalFrame normals;
};

/// Makes the vertices of the batch's edges: by crossing() and edge_normal(), to the last bit, on
/// every target.
/// target   Resolved.
/// normals  Whether to make normals, too; else they are left open, as gradients may be.
/// out      batch.count vertices.
void make_vertices(isa::VectorTarget target, const EdgeBatch& batch, const SlabFrame& frame,
                   bool normals, Vertex* out);

}  // namespace pxpl5::gp
