#include "gp_firmware/surface/measure.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>

// Highway compiles the part below once per kind of vector machine.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "gp_firmware/surface/measure.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "isa/contract/vector_target.hpp"

HWY_BEFORE_NAMESPACE();
namespace pxpl5::gp::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::ScalableTag<float>;
using Halves = hn::Half<Floats>;
using Doubles = hn::Repartition<double, Floats>;  ///< Has as many lanes as Halves.
using Float = hn::Vec<Floats>;
using Double = hn::Vec<Doubles>;
constexpr std::size_t max_lanes = hn::MaxLanes(Floats());
constexpr std::size_t block_floats = 4;  ///< Highway shuffles within 128 bits.

struct FloatVectors {
    Float x, y, z;
};
struct DoubleVectors {
    Double x, y, z;
};

/// Loads the first four floats of the vertices of every fourth triangle.
template <class D>
HWY_INLINE hn::Vec<D> load_blocks(D d, const Vertex* vertices, const std::uint32_t* index) {
    if constexpr (hn::MaxLanes(D()) == block_floats) {
        return hn::LoadU(d, &vertices[*index].p_voxel.x);
    } else {
        const hn::Half<D> half;
        constexpr std::size_t triangles = hn::MaxLanes(D()) / 2;
        return hn::Combine(d, load_blocks(half, vertices, index + 3 * triangles),
                           load_blocks(half, vertices, index));
    }
}

/// Loads the positions of the first corners of a vector's triangles. The first corner is *index.
HWY_INLINE FloatVectors corners(const Vertex* vertices, const std::uint32_t* index) {
    const Floats f;
    const Doubles d;  // Pairs of floats.
    const auto v_0 = load_blocks(f, vertices, index), v_1 = load_blocks(f, vertices, index + 3);
    const auto v_2 = load_blocks(f, vertices, index + 6), v_3 = load_blocks(f, vertices, index + 9);
    const auto xy_01 = hn::BitCast(d, hn::InterleaveLower(f, v_0, v_1));
    const auto xy_23 = hn::BitCast(d, hn::InterleaveLower(f, v_2, v_3));
    const auto zw_01 = hn::BitCast(d, hn::InterleaveUpper(f, v_0, v_1));
    const auto zw_23 = hn::BitCast(d, hn::InterleaveUpper(f, v_2, v_3));
    return {hn::BitCast(f, hn::InterleaveLower(d, xy_01, xy_23)),
            hn::BitCast(f, hn::InterleaveUpper(d, xy_01, xy_23)),
            hn::BitCast(f, hn::InterleaveLower(d, zw_01, zw_23))};
}

HWY_INLINE DoubleVectors lower(const FloatVectors& v) {
    const Doubles d;
    const Halves h;
    return {hn::PromoteTo(d, hn::LowerHalf(h, v.x)), hn::PromoteTo(d, hn::LowerHalf(h, v.y)),
            hn::PromoteTo(d, hn::LowerHalf(h, v.z))};
}

HWY_INLINE DoubleVectors upper(const FloatVectors& v) {
    const Doubles d;
    const Halves h;
    return {hn::PromoteTo(d, hn::UpperHalf(h, v.x)), hn::PromoteTo(d, hn::UpperHalf(h, v.y)),
            hn::PromoteTo(d, hn::UpperHalf(h, v.z))};
}

HWY_INLINE DoubleVectors difference(const DoubleVectors& p, const DoubleVectors& q) {
    return {p.x - q.x, p.y - q.y, p.z - q.z};
}

HWY_INLINE DoubleVectors cross(const DoubleVectors& p, const DoubleVectors& q) {
    return {p.y * q.z - q.y * p.z, p.z * q.x - q.z * p.x, p.x * q.y - q.x * p.y};
}

/// The terms of a vector's triangles, one by one.
struct Terms {
    alignas(64) std::array<double, max_lanes> doubled_areas, fluxes_by_six;
};

HWY_INLINE void terms_of_half(const DoubleVectors& a, const DoubleVectors& b,
                              const DoubleVectors& c, const glm::dmat3& cofactors,
                              std::size_t first, Terms& out) {
    const Doubles d;
    const DoubleVectors doubled_normal = cross(difference(b, a), difference(c, a));
    const auto component = [&](int r) {
        return hn::Set(d, cofactors[0][r]) * doubled_normal.x +
               hn::Set(d, cofactors[1][r]) * doubled_normal.y +
               hn::Set(d, cofactors[2][r]) * doubled_normal.z;
    };
    const Double x = component(0), y = component(1), z = component(2);
    hn::Store(hn::Sqrt(x * x + y * y + z * z), d, &out.doubled_areas[first]);
    hn::Store((a.x + b.x + c.x) * doubled_normal.x, d, &out.fluxes_by_six[first]);
}

HWY_INLINE void terms_of(const Vertex* vertices, const std::uint32_t* indices,
                         const glm::dmat3& cofactors, Terms& out) {
    const FloatVectors a = corners(vertices, indices), b = corners(vertices, indices + 1),
                       c = corners(vertices, indices + 2);
    terms_of_half(lower(a), lower(b), lower(c), cofactors, 0, out);
    terms_of_half(upper(a), upper(b), upper(c), cofactors, hn::Lanes(Doubles()), out);
}

TriangleSums sum_in_vectors(const Vertex* vertices, const std::uint32_t* indices,
                            std::size_t triangle_count, const glm::dmat3& cofactors) {
    const std::size_t lanes = hn::Lanes(Floats());
    TriangleSums sums;
    Terms terms;
    std::array<std::uint32_t, 3 * max_lanes> last{};  // Padded with triangles without area.
    for (std::size_t first = 0; first < triangle_count; first += lanes) {
        const std::size_t count = std::min(lanes, triangle_count - first);
        const std::uint32_t* these = indices + 3 * first;
        if (count < lanes) {
            these = std::copy_n(these, 3 * count, last.begin()) - 3 * count;
        }
        terms_of(vertices, these, cofactors, terms);
        for (std::size_t i = 0; i < count; ++i) {
            sums.doubled_area += terms.doubled_areas[i];
            sums.flux_by_six += terms.fluxes_by_six[i];
        }
    }
    return sums;
}

}  // namespace pxpl5::gp::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace pxpl5::gp {

void measure(const VolumeShape& shape, double inside_of_last_face, SlabMesh& mesh,
             VectorTarget target) {
    const glm::dmat3 m(shape.voxel_to_patient);
    // (M a) x (M b) = C (a x b) with the cofactors C, even if M mirrors.
    const glm::dmat3 cofactors(glm::cross(m[1], m[2]), glm::cross(m[2], m[0]),
                               glm::cross(m[0], m[1]));
    const TriangleSums sums = PXPL5_PER_TARGET(sum_in_vectors)[target](
        mesh.vertices.data(), mesh.indices.data(), mesh.indices.size() / 3, cofactors);
    // Triangles are wound for patient space. If M mirrors, they face inward in voxel space.
    const double scale = glm::determinant(m);
    mesh.counts.area_mm2 = sums.doubled_area / 2;
    mesh.counts.volume_mm3 =
        scale * sums.flux_by_six / 6 + std::abs(scale) * (shape.nx - 1) * inside_of_last_face;
}

}  // namespace pxpl5::gp
#endif
