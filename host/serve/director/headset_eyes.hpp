// Reads the eyes of a headset from a viewer's message.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>

#include "host/scene/stereo.hpp"

namespace pxpl5::host::serve {

inline constexpr int min_eye_px = 16;           ///< Width and height of one eye's picture.
inline constexpr double min_near_mm = 1e-3;     ///< Least distance of a near plane.
inline constexpr double max_eye_mm = 1e6;       ///< Limit of a far plane, and of a translation.
inline constexpr double rotation_error = 1e-3;  ///< Error of products of a rotation's columns.

/// The eyes of one pose of a headset.
struct HeadsetEyes {
    std::uint32_t pose = 0;  ///< Number that the page has given the pose, from 1.
    Size size;               ///< Pixels of one eye.
    Eyes eyes;
};

/// The object of the key "eyes". Throws RequestError (usage) that names the element and its value
/// if patient_to_eye is not a rotation and a translation, projection not a perspective of finite
/// depth, or a size or a number beyond the limits above.
HeadsetEyes read_headset_eyes(const nlohmann::json& eyes);

}  // namespace pxpl5::host::serve
