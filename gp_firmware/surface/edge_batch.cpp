#include "gp_firmware/surface/edge_batch.hpp"

#include <algorithm>
#include <cstring>

// Highway compiles the part below once per kind of vector machine.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "gp_firmware/surface/edge_batch.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "isa/contract/vector_target.hpp"

HWY_BEFORE_NAMESPACE();
namespace pxpl5::gp::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// All operations round like scalar ones, none is fused, and operands have the order of
// edge_vertex.hpp. So each lane has the bits that the functions of edge_vertex.hpp compute.
using Floats = hn::ScalableTag<float>;
using Halves = hn::Half<Floats>;
using Doubles = hn::Repartition<double, Floats>;  ///< Has as many lanes as Halves.
using Words = hn::Repartition<std::uint32_t, Floats>;
using Ints = hn::Repartition<std::int32_t, Floats>;
using Float = hn::Vec<Floats>;
using Half = hn::Vec<Halves>;
using Word = hn::Vec<Words>;

struct Vector3 {
    Float x, y, z;
};

/// The crossings of edges.
struct Crossings {
    Float t;
    Float p_xy;  ///< Position on edges along x or y.
    Float p_z;   ///< Position on edges along z.
};

struct HalfCrossings {
    Half t, p_xy, p_z;
};

HWY_INLINE HalfCrossings crossings_of_half(const SlabFrame& frame, Half value_0, Half value_1,
                                           Half start) {
    const Doubles d;
    const Halves h;
    const auto v_0 = hn::PromoteTo(d, value_0), v_1 = hn::PromoteTo(d, value_1);
    const auto quotient = (hn::Set(d, frame.isovalue) - v_0) / (v_1 - v_0);
    const auto is_between =
        hn::And(hn::Ge(quotient, hn::Zero(d)), hn::Le(quotient, hn::Set(d, 1.0)));
    const auto t = hn::IfThenElse(is_between, quotient, hn::Set(d, 0.5));
    return {hn::DemoteTo(h, t), hn::DemoteTo(h, hn::PromoteTo(d, start) + t),
            hn::DemoteTo(h, hn::Set(d, frame.places[0]) + t * hn::Set(d, frame.height))};
}

HWY_INLINE Crossings crossings(const SlabFrame& frame, Float value_0, Float value_1, Float start) {
    const Floats f;
    const Halves h;
    const HalfCrossings low = crossings_of_half(frame, hn::LowerHalf(h, value_0),
                                                hn::LowerHalf(h, value_1), hn::LowerHalf(h, start));
    const HalfCrossings high = crossings_of_half(
        frame, hn::UpperHalf(h, value_0), hn::UpperHalf(h, value_1), hn::UpperHalf(h, start));
    return {hn::Combine(f, high.t, low.t), hn::Combine(f, high.p_xy, low.p_xy),
            hn::Combine(f, high.p_z, low.p_z)};
}

HWY_INLINE Vector3 gradients(const std::uint32_t* xy, const std::int32_t* z, Float z_factor) {
    const Floats f;
    const Ints i;
    const auto packed = hn::BitCast(i, hn::Load(Words(), xy));
    const auto x = hn::ShiftRight<16>(hn::ShiftLeft<16>(packed)), y = hn::ShiftRight<16>(packed);
    return {hn::ConvertTo(f, x), hn::ConvertTo(f, y), hn::ConvertTo(f, hn::Load(i, z)) * z_factor};
}

HWY_INLINE Vector3 outward(const NormalFrame& frame, const Vector3& gradient) {
    const Floats f;
    const auto row = [&](int r) {
        return hn::Set(f, frame.column(0)[r]) * gradient.x +
               hn::Set(f, frame.column(1)[r]) * gradient.y +
               hn::Set(f, frame.column(2)[r]) * gradient.z;
    };
    return {row(0), row(1), row(2)};
}

HWY_INLINE Float length_squared(const Vector3& n) {
    return n.x * n.x + n.y * n.y + n.z * n.z;
}

/// The low halves of the lanes hold the component.
HWY_INLINE Word pack_component(Float component, Float factor) {
    const Floats f;
    const auto scaled = component * factor;
    const auto rounded = scaled + hn::CopySign(hn::Set(f, 0.5F), scaled);
    return hn::And(hn::BitCast(Words(), hn::ConvertTo(Ints(), rounded)), hn::Set(Words(), 0xffff));
}

/// The edges of one vector, from batch[first] on.
class Lanes {
  public:
    HWY_INLINE Lanes(const EdgeBatch& batch, std::size_t first, const SlabFrame& frame)
        : batch_(batch),
          first_(first),
          frame_(frame),
          row_and_kind_(hn::Load(Words(), &batch.row_and_kind[first])),
          value_0_(hn::Load(Floats(), &batch.value_0[first])),
          value_1_(hn::Load(Floats(), &batch.value_1[first])) {}

    HWY_INLINE hn::Mask<Floats> is(std::uint32_t kind) const {
        return hn::RebindMask(Floats(), hn::TestBit(row_and_kind_, hn::Set(Words(), kind)));
    }

    /// Positions, and t for normal().
    HWY_INLINE Vector3 positions(Float& t) const {
        const Floats f;
        const auto x = to_float(hn::Load(Words(), &batch_.x[first_]));
        const auto y = to_float(hn::ShiftRight<edge_kind_bits>(row_and_kind_));
        const auto is_y = is(along_y), is_z = is(along_z);
        const Crossings crossed = crossings(frame_, value_0_, value_1_, hn::IfThenElse(is_y, y, x));
        t = crossed.t;
        const auto slice =
            hn::IfThenElse(is(lower_end_above), hn::Set(f, static_cast<float>(frame_.places[1])),
                           hn::Set(f, static_cast<float>(frame_.places[0])));
        return {hn::IfThenElse(hn::Or(is_y, is_z), x, crossed.p_xy),
                hn::IfThenElse(is_y, crossed.p_xy, y), hn::IfThenElse(is_z, crossed.p_z, slice)};
    }

    /// Sets x and y packed, and z.
    HWY_INLINE void normals(Float t, Word& xy, Word& z) const {
        const Floats f;
        const Vector3 g_0 = gradients(&batch_.gradient_xy_0[first_], &batch_.gradient_z_0[first_],
                                      z_factor(lower_end_above));
        const Vector3 g_1 = gradients(&batch_.gradient_xy_1[first_], &batch_.gradient_z_1[first_],
                                      z_factor(upper_end_above));
        Vector3 n =
            outward(frame_.normals, {g_0.x + t * (g_1.x - g_0.x), g_0.y + t * (g_1.y - g_0.y),
                                     g_0.z + t * (g_1.z - g_0.z)});
        Float squared = length_squared(n);
        const auto is_direction = hn::Gt(squared, hn::Zero(f));
        if (!hn::AllTrue(f, is_direction)) [[unlikely]] {
            const Vector3 m = outward(frame_.normals, along_edges());
            n = {hn::IfThenElse(is_direction, n.x, m.x), hn::IfThenElse(is_direction, n.y, m.y),
                 hn::IfThenElse(is_direction, n.z, m.z)};
            squared = length_squared(n);
        }
        const auto factor = hn::Set(f, normal_one) / hn::Sqrt(squared);
        xy = hn::Or(pack_component(n.x, factor), hn::ShiftLeft<16>(pack_component(n.y, factor)));
        z = pack_component(n.z, factor);
    }

  private:
    static HWY_INLINE Float to_float(Word word) {
        return hn::ConvertTo(Floats(), hn::BitCast(Ints(), word));
    }

    HWY_INLINE Float z_factor(std::uint32_t end_above) const {
        const Floats f;
        return hn::IfThenElse(is(end_above), hn::Set(f, frame_.z_factors[1]),
                              hn::Set(f, frame_.z_factors[0]));
    }

    /// Gradients along the edges.
    HWY_INLINE Vector3 along_edges() const {
        const Floats f;
        const auto is_y = is(along_y), is_z = is(along_z);
        // One end of a crossed edge is inside: the greater one, or the one that is a number.
        const auto is_inside =
            hn::And(hn::Eq(value_0_, value_0_), hn::Not(hn::Lt(value_0_, value_1_)));
        const auto rise = hn::IfThenElse(is_inside, hn::Set(f, -1.0F), hn::Set(f, 1.0F));
        return {hn::IfThenZeroElse(hn::Or(is_y, is_z), rise), hn::IfThenElseZero(is_y, rise),
                hn::IfThenElseZero(is_z, rise)};
    }

    const EdgeBatch& batch_;
    std::size_t first_;
    const SlabFrame& frame_;
    Word row_and_kind_;
    Float value_0_, value_1_;
};

/// Stores vertices: 16 bytes from x, y, z and `xy`, the rest from `z`.
HWY_INLINE void store(const Vector3& p, Word xy, Word z, std::size_t count, Vertex* out) {
    constexpr std::size_t head_bytes = offsetof(Vertex, normal) + 2 * sizeof(std::int16_t);
    static_assert(head_bytes == 4 * sizeof(float) && sizeof(Vertex) == 5 * sizeof(float));
    HWY_ALIGN std::array<float, 4 * hn::MaxLanes(Floats())> heads;
    HWY_ALIGN std::array<std::uint32_t, hn::MaxLanes(Floats())> tails;
    hn::StoreInterleaved4(p.x, p.y, p.z, hn::BitCast(Floats(), xy), Floats(), heads.data());
    hn::Store(z, Words(), tails.data());
    auto* to = reinterpret_cast<std::byte*>(out);
    for (std::size_t i = 0; i < count; ++i, to += sizeof(Vertex)) {
        std::memcpy(to, &heads[4 * i], head_bytes);
        std::memcpy(to + head_bytes, &tails[i], sizeof(Vertex) - head_bytes);
    }
}

void make_vertices_in_vectors(const EdgeBatch& batch, const SlabFrame& frame, bool normals,
                              Vertex* out) {
    const std::size_t lanes = hn::Lanes(Floats());
    for (std::size_t first = 0; first < batch.count; first += lanes) {
        const Lanes edges(batch, first, frame);
        Float t;
        const Vector3 p = edges.positions(t);
        Word xy = hn::Zero(Words()), z = xy;
        if (normals) {
            edges.normals(t, xy, z);
        }
        store(p, xy, z, std::min(lanes, batch.count - first), out + first);
    }
}

}  // namespace pxpl5::gp::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace pxpl5::gp {

void make_vertices(VectorTarget target, const EdgeBatch& batch, const SlabFrame& frame,
                   bool normals, Vertex* out) {
    PXPL5_PER_TARGET(make_vertices_in_vectors)[target](batch, frame, normals, out);
}

}  // namespace pxpl5::gp
#endif
