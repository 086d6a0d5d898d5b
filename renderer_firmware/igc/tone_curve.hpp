// The tone curve of a surface: bends the sum of the lights where they could overexpose the surface.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

namespace pxpl5::renderer {

namespace light_field {

inline constexpr double one = 16384;     ///< 1.0 in the field `light` of programs/registers.pxasm.
inline constexpr double half_step = 16;  ///< finish.pxasm drops 5 bits of `light`.
inline constexpr double finish_one = 512;  ///< 1.0 of the bits that finish.pxasm uses.
inline constexpr std::int64_t per_step = 32;

/// Whether this much light makes a channel brighter than 255.
inline bool is_above_limit(double light, int channel) {
    return light + 1 / finish_one > 255.0 / std::max(channel, 1);
}

/// The most light, in units of the field, that does not. The field ends at 4.0.
inline std::int64_t limit(int channel) {
    const auto steps = static_cast<std::int64_t>(255.0 / std::max(channel, 1) * finish_one);
    return std::min((steps + 1) * per_step - 1, std::int64_t{0xffff});
}

}  // namespace light_field

/// Light x above the knee k becomes x - a (x - k)^2: the curve has slope 1 at the knee and ends at
/// the limit with the brightest light. It does not fall before, because it begins at least twice as
/// far below its end as the end exceeds the limit. All in units of the field `light`.
struct ToneCurve {
    std::int64_t knee = 0;
    std::int64_t bend = 0;            ///< a, in units of 2^-15 per 1.0 of light.
    std::int64_t limit = 0;           ///< Makes the brightest channel 255; the bend is rounded.
    std::optional<std::int64_t> cut;  ///< Light above it is cut first: there the curve is level.
};

/// Returns the curve of a surface; nothing if no light of the frame overexposes the surface.
///
/// brightest  The most light that a pixel of the frame can have; 1 shows the surface's color.
/// channel    The brightest channel of the surface's color, 0..255.
inline std::optional<ToneCurve> tone_curve(double brightest, int channel) {
    constexpr double bend_one = 32768;
    constexpr double least_width = 0.27;  // Keeps `bend` below 2^16.
    const auto in_field = [](double light) {
        return std::llround(light * light_field::one + light_field::half_step);
    };
    const double limit = 255.0 / std::max(channel, 1);
    if (!light_field::is_above_limit(brightest, channel)) {
        return std::nullopt;
    }
    brightest += 1 / light_field::finish_one;
    const double end = std::min(brightest, 2 * limit);
    const double width = std::max(2 * (end - limit), least_width);
    ToneCurve curve;
    curve.knee = in_field(end - width);
    curve.bend = std::llround((end - limit) / (width * width) * bend_one);
    curve.limit = light_field::limit(channel);
    if (brightest > end) {
        curve.cut = in_field(end);
    }
    return curve;
}

}  // namespace pxpl5::renderer
