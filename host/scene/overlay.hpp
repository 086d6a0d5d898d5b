// The marks of a clinical viewer over a picture: the patient's directions, a scale bar and a
// legend.
#pragma once

#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

#include "host/scene/camera.hpp"
#include "host/scene/marks.hpp"
#include "host/scene/scene.hpp"

namespace pxpl5::host {

/// Directions whose components differ by less are equal: rounding makes such differences.
inline constexpr double direction_rounding = 1e-9;

/// A direction in patient axes (x left, y posterior, z superior) as its letters, the largest
/// component first: L R, P A, S I. A component counts from sin 22.5 degrees of the whole on, so
/// that a direction between two axes has two letters, as "RA", and a small turn none too many.
/// Equal components in the order x, y, z. Empty for the null vector.
std::string direction_letters(const glm::dvec3& direction);

/// A scale bar: a round length, and how long that is in the picture.
struct ScaleBar {
    double length_mm = 0;
    double length_px = 0;
};

/// The longest bar of 1, 2 or 5 times a power of ten millimeters that is at most `most_px` long, at
/// the distance of the subject's center: the picture is a perspective, what is nearer is larger.
ScaleBar scale_bar(const Camera& camera, const Subject& subject, Size size, double most_px);

/// One line of the legend: a surface's color, name and isovalue.
struct LegendLine {
    MarkColor color;
    std::string text;
};

/// The words of a picture about its volume.
struct Caption {
    std::string title;    ///< Bottom line, as the volume's name; UTF-8. A long title is cut.
    std::string warning;  ///< Never cut: it wraps at the top left. ASCII, empty for none.
};

/// Contents of the marks. The flags switch parts off.
struct Overlay {
    Camera camera;
    Subject subject;
    Size size;
    MarkColor background{18, 22, 30,
                         255};  ///< Background of the picture: ink is light over a dark background.
    Caption caption;
    std::vector<LegendLine> legend;  ///< Above the title; what has no room is counted.
    bool letters = true;             ///< Patient directions at the four sides.
    bool directions = true;          ///< The six directions as a small body at the top right.
    bool scale = true;               ///< The scale bar.
};

/// Where a warning stands: its top left corner, how wide a line may be, and the letters' style.
struct WarningPlace {
    glm::vec2 at{0};
    double room_px = 0;
    float height_px = 12, halo_px = 2;
    bool over_light = false;  ///< Over a light background: the letters are dark.
};

/// A warning of ASCII as texts, one per line, from the top downwards. It wraps between words and
/// is never cut.
std::vector<PictureMark> warning_marks(const std::string& warning, const WarningPlace& place);

/// The legend of a scene's visible surfaces: "bone  300".
std::vector<LegendLine> legend_of(std::span<const Surface> surfaces);

/// The marks, to be drawn in order. Sizes follow the picture's shorter side; below
/// `smallest_legend_px` there is room for letters, the scale bar and the warning alone, below
/// `smallest_overlay_px` for none.
std::vector<PictureMark> overlay_marks(const Overlay& overlay);

inline constexpr int smallest_overlay_px = 96, smallest_legend_px = 200;

/// The whole overlay of a scene in which `subject` is shown.
std::vector<PictureMark> overlay_marks(const Scene& scene, const Subject& subject,
                                       const Caption& caption);

}  // namespace pxpl5::host
