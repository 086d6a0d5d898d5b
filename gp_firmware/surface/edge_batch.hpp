// A batch of crossed edges. Their ends lie side by side for vector code.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "gp_firmware/surface/edge_vertex.hpp"
#include "gp_firmware/surface/mesh.hpp"
#include "isa/contract/vector_target.hpp"

namespace pxpl5::gp {

/// Direction and slices of an edge: bits of EdgeBatch::row_and_kind.
enum EdgeKind : std::uint32_t {
    lower_end_above = 1,  ///< The edge's lower end lies in the slab's upper slice.
    upper_end_above = 2,  ///< The edge's upper end lies in the slab's upper slice.
    along_y = 4,
    along_z = 8,  ///< An edge with neither bit runs along x.
};
inline constexpr int edge_kind_bits = 4;

/// Edges of one slab for make_vertices(). The columns are undefined beyond `count`.
struct EdgeBatch {
    static constexpr std::size_t capacity = 256;
    template <class T>
    using Column = std::array<T, capacity>;

    std::size_t count = 0;
    alignas(64) Column<float> value_0{}, value_1{};  ///< Every scalar type fits exactly.
    alignas(64) Column<std::uint32_t> gradient_xy_0{}, gradient_xy_1{};  ///< x in the low half.
    alignas(64) Column<std::int32_t> gradient_z_0{}, gradient_z_1{};
    alignas(64) Column<std::uint32_t> x{};             ///< Voxel x of the lower end.
    alignas(64) Column<std::uint32_t> row_and_kind{};  ///< y << edge_kind_bits | EdgeKind.

    void set_gradients(std::size_t i, const Gradient& lower, const Gradient& upper) {
        std::memcpy(&gradient_xy_0[i], lower.data(), sizeof(std::uint32_t));
        std::memcpy(&gradient_xy_1[i], upper.data(), sizeof(std::uint32_t));
        gradient_z_0[i] = lower[2];
        gradient_z_1[i] = upper[2];
    }
};

/// Values that all edges of a slab share.
struct SlabFrame {
    double isovalue = 0;
    std::array<double, 2> places{};    ///< Places of the slices in the grid, the lower first.
    double height = 1;                 ///< Distance of the slices.
    std::array<float, 2> z_factors{};  ///< z_factor() of the slices.
    NormalFrame normals;
};

/// Makes the vertices of the batch's edges, with the same bits as crossing() and edge_normal() on
/// every target.
/// target   A resolved target.
/// normals  Makes normals. Without them, normals and gradients are undefined.
/// out      Receives batch.count vertices.
void make_vertices(VectorTarget target, const EdgeBatch& batch, const SlabFrame& frame,
                   bool normals, Vertex* out);

}  // namespace pxpl5::gp
