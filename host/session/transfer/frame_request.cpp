#include "host/session/transfer/frame_request.hpp"

#include <array>
#include <cmath>
#include <glm/gtc/constants.hpp>

#include "host/scene/clip.hpp"
#include "isa/contract/region_layout.hpp"

namespace pxpl5::host {

namespace {

namespace schema = bus::schema;

schema::Matrix to_wire(const glm::dmat4& m) {
    std::array<double, 16> values{};
    for (int column = 0; column < 4; ++column) {
        for (int row = 0; row < 4; ++row) {
            values[static_cast<std::size_t>(column * 4 + row)] = m[column][row];
        }
    }
    return schema::Matrix(flatbuffers::make_span(values));
}

schema::Rgb to_wire(Color color) {
    return {color.r, color.g, color.b};
}

schema::Light to_wire(const Light& light) {
    const double azimuth = light.azimuth_deg / 180.0 * glm::pi<double>();
    const double elevation = light.elevation_deg / 180.0 * glm::pi<double>();
    const schema::Vec3 direction(static_cast<float>(std::sin(azimuth) * std::cos(elevation)),
                                 static_cast<float>(std::sin(elevation)),
                                 static_cast<float>(std::cos(azimuth) * std::cos(elevation)));
    return {direction, static_cast<float>(light.intensity)};
}

/// Moves the picture so that the pass's samples lie in the middle of the pixels.
glm::dmat4 moved(glm::dmat4 projection, Size size, Pass pass) {
    constexpr double steps = 1 << isa::region::subpixel_bits;
    const glm::dvec2 offset_px = glm::dvec2(sample_offset(pass)) / steps;
    // Clip space is 2 wide and 2 high, before the division by w, and y goes up.
    for (int column = 0; column < 4; ++column) {
        projection[column][0] -= offset_px.x * 2 / size.width * projection[column][3];
        projection[column][1] += offset_px.y * 2 / size.height * projection[column][3];
    }
    return projection;
}

/// The projection of a part of the picture. Clip space is 2 wide and 2 high, before the division by
/// w, and y goes up.
glm::dmat4 cropped(glm::dmat4 projection, const PicturePart& part, Size size) {
    const glm::dvec2 whole(part.whole.width, part.whole.height), own(size.width, size.height);
    const glm::dvec2 scale = whole / own;
    const glm::dvec2 middle = (whole - 2.0 * glm::dvec2(part.left, part.top)) / own - 1.0;
    for (int column = 0; column < 4; ++column) {
        const double w = projection[column][3];
        projection[column][0] = projection[column][0] * scale.x + w * middle.x;
        projection[column][1] = projection[column][1] * scale.y - w * middle.y;
    }
    return projection;
}

std::unique_ptr<schema::ViewT> view_of(const CameraMatrices& camera, const Scene& scene,
                                       const Stage& stage, Pass pass) {
    auto view = std::make_unique<schema::ViewT>();
    view->voxel_to_eye =
        std::make_unique<schema::Matrix>(to_wire(camera.patient_to_eye * stage.voxel_to_patient));
    view->projection =
        std::make_unique<schema::Matrix>(to_wire(moved(camera.projection, scene.size, pass)));
    return view;
}

/// The entry of a slice plane in the list of surfaces: no surface of the scene has its id.
schema::SurfaceDraw plane_entry() {
    return {plane_surface_id, 0, schema::Rgb(), false, SlabChoice::all, full_opacity, 0, 0};
}

}  // namespace

std::vector<CameraMatrices> cameras_of(const Scene& scene, const Subject& subject) {
    const Size whole = scene.part ? scene.part->whole : scene.size;
    const double aspect = static_cast<double>(whole.width) / whole.height;
    const CameraMatrices middle = camera_matrices(scene.camera, subject, aspect);
    std::vector<CameraMatrices> cameras =
        scene.stereo.mode == StereoMode::off
            ? std::vector{middle}
            : eye_matrices(middle, eye_places(scene.stereo, scene.camera, subject));
    if (scene.part) {
        for (CameraMatrices& camera : cameras) {
            camera.projection = cropped(camera.projection, *scene.part, scene.size);
        }
    }
    return cameras;
}

std::vector<DrawnSurface> drawn_surfaces(const Scene& scene, const Stage& stage) {
    std::vector<DrawnSurface> drawn;
    for (const Surface& surface : stage.surfaces) {
        if (!surface.visible || is_compared(stage.surfaces, surface)) {
            continue;
        }
        if (!scene.tint_gaps || !stage.has_gaps) {
            drawn.push_back({&surface, SlabChoice::all, surface.color});
            continue;
        }
        drawn.push_back({&surface, SlabChoice::outside_gaps, surface.color});
        drawn.push_back({&surface, SlabChoice::in_gaps, scene.gap_color});
    }
    return drawn;
}

bus::Payload frame_request(const Scene& scene, const Stage& stage, std::uint32_t frame,
                           std::span<const std::uint64_t> region_costs, ReadBack read_back,
                           Pass pass, bool counts) {
    schema::DrawFrameT draw;
    draw.frame = frame;
    draw.width = static_cast<std::uint32_t>(scene.size.width);
    draw.height = static_cast<std::uint32_t>(scene.size.height);
    for (const CameraMatrices& camera : stage.cameras) {
        draw.views.push_back(view_of(camera, scene, stage, pass));
    }
    for (const Light& light : scene.lights) {
        draw.lights.push_back(to_wire(light));
    }
    draw.ambient = static_cast<float>(scene.material.ambient);
    draw.specular = static_cast<float>(scene.material.specular);
    draw.specular_power = scene.material.specular_power;
    draw.background = std::make_unique<schema::Rgb>(to_wire(scene.background));
    for (const DrawnSurface& drawn : drawn_surfaces(scene, stage)) {
        const Surface& surface = *drawn.surface;
        draw.surfaces.push_back(schema::SurfaceDraw(
            surface.id, surface.revision, to_wire(drawn.color), surface.cull_back, drawn.slabs,
            static_cast<std::uint8_t>(surface.opacity), static_cast<std::uint8_t>(stage.detail),
            static_cast<std::uint8_t>(surface.rim)));
    }
    for (const ScenePlane& plane : stage.planes) {
        const auto& [width, level] = scene.planes_window;
        draw.surfaces.push_back(plane_entry());
        draw.planes.emplace_back(static_cast<std::uint8_t>(plane.axis),
                                 static_cast<std::uint32_t>(plane.index), level - width / 2,
                                 level + width / 2);
    }
    for (const SceneClip& clip : scene.clips) {
        const glm::vec4 plane(grid_plane(clip.plane, stage.voxel_to_patient));
        draw.clip_planes.emplace_back(plane.x, plane.y, plane.z, plane.w);
    }
    draw.read_depths = read_back == ReadBack::pixels_and_depths;
    draw.read_back = pass.is_last();
    draw.sample = static_cast<std::uint8_t>(pass.sample);
    draw.samples = static_cast<std::uint8_t>(pass.samples);
    draw.counts = counts;
    draw.region_costs.assign(region_costs.begin(), region_costs.end());
    return bus::pack(draw);
}

}  // namespace pxpl5::host
