// Two eyes: the matrices of each, and how the pair becomes one picture.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "host/base/command_line.hpp"
#include "host/scene/camera.hpp"

namespace pxpl5::host {

enum class StereoMode : std::uint8_t {
    off,
    anaglyph,      ///< One picture for glasses with a red left and a cyan right lens.
    side_by_side,  ///< The left eye's picture at the left.
    crossed,       ///< The left eye's picture at the right, for viewers who cross their eyes.
    rows           ///< Rows 0, 2, .. from the left eye, 1, 3, .. from the right, for 3-D monitors.
};

/// The choice of the user.
struct Stereo {
    StereoMode mode = StereoMode::off;
    double separation_mm = 0;   ///< Between the eyes, in the patient; 0: see eye_places().
    double convergence_mm = 0;  ///< From the eyes to what appears at the screen; 0: the center.
    friend bool operator==(const Stereo&, const Stereo&) = default;
};

/// "off", "anaglyph", "sbs", "cross", "rows".
std::string_view stereo_word(StereoMode mode);
/// The mode of that word; nothing if there is none.
std::optional<StereoMode> find_stereo(std::string_view word);

/// The eyes lie on both sides of the camera, on a line that is parallel to the picture's rows.
struct EyePlaces {
    double separation_mm = 0;   ///< Between the eyes.
    double convergence_mm = 0;  ///< From the eyes to the plane whose points have no parallax.
};

/// The user's values, or 0.035 of the camera's distance divided by the zoom, and the distance of
/// the subject's center. The parallax of the subject's nearest point is then about 1/30 of the
/// picture's height. Most people can fuse this.
EyePlaces eye_places(const Stereo& stereo, const Camera& camera, const Subject& subject);

/// The matrices of the left and the right eye. The axes of both are parallel, and the frusta
/// asymmetric, so that no point has a vertical parallax.
std::vector<CameraMatrices> eye_matrices(const CameraMatrices& middle, const EyePlaces& places);

/// Two eyes that no camera of a scene determines, as those of a headset.
struct Eyes {
    CameraMatrices left, right;
};

/// The size of a pair as one picture.
///
/// eye  Size of the picture of one eye.
Size composed_size(Size eye, StereoMode mode);

/// A pair as one picture.
///
/// pair  The left eye's picture over the right eye's; red in the low byte.
/// mode  Not off.
std::vector<std::uint32_t> composed(std::span<const std::uint32_t> pair, Size eye, StereoMode mode);

/// A pixel of a composed picture, as one eye sees it.
struct EyePixel {
    int eye = 0;  ///< 0 left, 1 right.
    int x = 0, y = 0;
};

/// The eye and the pixel that pixel (x, y) of a composed picture shows; of an anaglyph the left
/// one. The pixel must lie in the picture.
EyePixel eye_pixel(int x, int y, Size eye, StereoMode mode);

}  // namespace pxpl5::host
