// A slice as a gray picture, with the contours of surfaces and the patient's directions as marks.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/scene/oblique.hpp"
#include "host/scene/overlay.hpp"
#include "host/scene/slice.hpp"
#include "host/session/session.hpp"

namespace pxpl5::host {

/// A surface's contours in a slice.
struct SurfaceContour {
    const Surface* surface = nullptr;
    std::vector<ContourPiece> pieces;
};

/// The contours of the visible surfaces, in drawing order, with all components of each. Surfaces
/// that `compare` made have no contours.
std::vector<SurfaceContour> contours_of(const Scene& scene, const Slice& slice);

/// The same in an oblique slice with these values: they follow its pixels.
std::vector<SurfaceContour> contours_of(const Scene& scene, const ObliquePlane& plane,
                                        const std::vector<float>& values);

/// Settings by which the 3D picture hides parts that the contours show: "clip L 20", "components of
/// bone". Empty if there are none, or no contours.
std::vector<std::string> hidden_in_3d(const Scene& scene,
                                      const std::vector<SurfaceContour>& contours);

inline constexpr std::size_t max_contour_marks = 50'000;

struct SlicePicture {
    Picture picture;
    std::vector<PictureMark> marks;
};

/// The slice in the patient's proportions, as large as fits into `size`; between voxels values are
/// linear, also where these are unevenly spaced. Beside values that are no number, a pixel has the
/// nearest value.
///
/// caption  The title at the bottom left, and the warning at the top left.
/// Throws   RequestError (failed) for more than max_contour_marks pieces of contours.
SlicePicture slice_picture(const Slice& slice, const std::vector<SurfaceContour>& contours,
                           const GrayWindow& window, Size size, const Caption& caption);

}  // namespace pxpl5::host
