// Vectors of 32-bit numbers, one vertex or triangle in each lane. Included behind
// hwy/foreach_target.h, once per vector target, hence the guard that flips.
#if defined(PXPL5_GP_LANES_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef PXPL5_GP_LANES_INL
#undef PXPL5_GP_LANES_INL
#else
#define PXPL5_GP_LANES_INL
#endif

#include <hwy/highway.h>

#include <cstddef>
#include <cstdint>

HWY_BEFORE_NAMESPACE();
namespace pxpl5::gp::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using DI = hn::ScalableTag<std::int32_t>;
using DU = hn::RebindToUnsigned<DI>;
using DF = hn::RebindToFloat<DI>;
using I = hn::Vec<DI>;
using U = hn::Vec<DU>;
using F = hn::Vec<DF>;
inline constexpr std::size_t lanes = HWY_LANES(std::int32_t);

HWY_INLINE I splat(int value) {
    return hn::Set(DI(), value);
}
HWY_INLINE F splat(float value) {
    return hn::Set(DF(), value);
}

}  // namespace pxpl5::gp::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // PXPL5_GP_LANES_INL
