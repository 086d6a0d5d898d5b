// The scene: everything that a frame depends on besides the volume.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "generated/vocabulary.hpp"
#include "host/base/command_line.hpp"
#include "host/scene/camera.hpp"
#include "host/scene/stereo.hpp"
#include "host/volume/volume.hpp"

namespace pxpl5::host {

#define LIMIT(type, name, value, meaning) inline constexpr type name = value;
#include "host/scene/limits.def"
#undef LIMIT

/// Which connected components of a surface are drawn.
struct ComponentFilter {
    enum class Kind : std::uint8_t { all, largest, at_least_mm2, at_least_ml, at_point };
    Kind kind = Kind::all;
    double least = 0;             ///< For the kinds at_least_*; largest is by number of triangles.
    glm::dvec3 p_mm{0};           ///< For at_point: the component nearest to it; patient, LPS.
    bool fills_cavities = false;  ///< The cavities of the drawn components are not drawn.
    friend bool operator==(const ComponentFilter&, const ComponentFilter&) = default;
};

struct Surface {
    std::string name;
    std::uint16_t id = 0;        ///< Number on the ring. No other surface of the scene has it.
    std::uint32_t revision = 0;  ///< Counts the isovalues that it has had.
    double isovalue = 0;
    CaseRule table = CaseRule::watertight;
    Color color{236, 226, 200};
    bool cull_back = false;  ///< Triangles that turn their back are not drawn.
    bool visible = true;
    int opacity = full_opacity;  ///< Sixteenths of the pixels that show it; 1..16.
    int rim = 0;                 ///< Light at its edges, sixteenths; 0..max_rim.
    ComponentFilter components;
    std::string compared_with;  ///< For a surface made by `compare`: the compared surface.
};

/// Directional light as seen by the viewer.
struct Light {
    double azimuth_deg = 0;    ///< Towards the picture's right; 0 is the viewer's direction.
    double elevation_deg = 0;  ///< Upwards.
    double intensity = 1;
    friend bool operator==(const Light&, const Light&) = default;
};

struct Material {
    double ambient = 0.16, specular = 0.25;  ///< 0..1.
    std::uint32_t specular_power = 24;       ///< 1..128.
    friend bool operator==(const Material&, const Material&) = default;
};

/// One clip plane.
struct SceneClip {
    std::string words;  ///< The words of the command: "R 20", "box 0,0,0 63,63,30".
    glm::dvec4 plane;   ///< In patient mm, LPS; keeps plane . (x, y, z, 1) >= 0.
    friend bool operator==(const SceneClip&, const SceneClip&) = default;
};

/// A slice of the volume that pictures show beside the surfaces.
struct ScenePlane {
    int axis = 2;   ///< Voxel axis: 0 x, 1 y, 2 z.
    int index = 0;  ///< Voxel along the axis, from 0; z counts slices.
    friend bool operator==(const ScenePlane&, const ScenePlane&) = default;
};

/// The detail that surfaces are drawn with.
struct DetailChoice {
    bool is_auto = false;  ///< Moving pictures are simplified if necessary; all others are exact.
    int detail = 0;        ///< Otherwise: 0 exact; 1..max_detail, see SurfaceDraw.
    friend bool operator==(const DetailChoice&, const DetailChoice&) = default;
};

/// The place of a picture that is a part of a larger one.
struct PicturePart {
    Size whole;             ///< The larger picture of one eye.
    int left = 0, top = 0;  ///< Pixels.
};

struct Scene {
    Camera camera;
    /// From above left, and a weaker one from the right, so that no side is without shape.
    std::vector<Light> lights = {{-28, 32, 0.72}, {55, -8, 0.26}};
    Material material;
    Color background{18, 22, 30};
    Size size{512, 512};              ///< The picture of one eye.
    std::optional<PicturePart> part;  ///< Set while a large picture is drawn in parts.
    int frame = 1;                    ///< Number of the shown volume in its time series.
    std::vector<Surface> surfaces;    ///< In drawing order.
    std::vector<SceneClip> clips;     ///< Only points on the kept side of all planes are drawn.
    std::vector<ScenePlane> planes;   ///< Ascending by axis, each axis at most once.
    GrayWindow planes_window;         ///< The window of all planes.
    bool tint_gaps = false;           ///< Surfaces across missing slices are drawn in `gap_color`.
    Color gap_color{226, 84, 62};
    int samples = 1;  ///< Samples per pixel of a picture, one of sample_counts.
    DetailChoice detail;
    Stereo stereo;
    bool overlay = true;  ///< Pictures in files carry orientation letters and a scale bar.
};

/// Whether `compare` shows two other surfaces in place of this one.
inline bool is_compared(std::span<const Surface> surfaces, const Surface& surface) {
    return std::ranges::any_of(surfaces, [&](const Surface& other) {
        return !other.compared_with.empty() && other.compared_with == surface.name;
    });
}

}  // namespace pxpl5::host
