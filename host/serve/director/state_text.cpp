#include "host/serve/director/state_text.hpp"

#include <fmt/core.h>

#include <glm/gtc/type_ptr.hpp>

#include "generated/page_schema.hpp"
#include "host/base/error.hpp"
#include "host/commands/text/volume_text.hpp"
#include "host/session/transfer/detail.hpp"
#include "host/volume/identity.hpp"

namespace pxpl5::host::serve {

namespace {

std::vector<double> numbers(const glm::dmat4& matrix) {
    return {glm::value_ptr(matrix), glm::value_ptr(matrix) + 16};
}
std::vector<double> numbers(const glm::dvec3& v) {
    return {v.x, v.y, v.z};
}

std::string color_text(const Color& color) {
    return fmt::format("#{:02x}{:02x}{:02x}", color.r, color.g, color.b);
}

/// The filter in the form that `components` reads.
std::string filter_text(const ComponentFilter& filter) {
    const std::string_view end = filter.fills_cavities ? " cavities=no" : "";
    switch (filter.kind) {
        case ComponentFilter::Kind::largest:
            return fmt::format("largest{}", end);
        case ComponentFilter::Kind::at_least_mm2:
            return fmt::format("min_mm2={:.6g}{}", filter.least, end);
        case ComponentFilter::Kind::at_least_ml:
            return fmt::format("min_ml={:.6g}{}", filter.least, end);
        case ComponentFilter::Kind::at_point:
            return fmt::format("at {:.1f},{:.1f},{:.1f} mm{}", filter.p_mm.x, filter.p_mm.y,
                               filter.p_mm.z, end);
        case ComponentFilter::Kind::all:
            break;
    }
    return "all";
}

VolumeState volume_state(const Session& session) {
    const Volume& volume = session.volumes.volume();
    const Subject subject = session.frames.subject();
    VolumeState state;
    state.name = volume.name;
    state.source = volume.source;
    state.identity = identity_of(volume);
    state.series_identity = series_identity_of(volume, session.volumes.loads());
    state.frame = volume.frame;
    state.frames = volume.frames;
    state.frame_ms = volume.frame_ms;
    state.time_ms = time_ms(volume, volume.frame).value_or(-1);
    state.size = numbers(glm::dvec3(volume.nx, volume.ny, volume.nz));
    state.spacing_mm = numbers(spacing_mm(volume));
    state.modality = volume.modality;
    state.unit = !volume.unit.empty() ? volume.unit : volume.modality == "CT" ? "HU" : "";
    state.gradient = enum_name(volume.gradient);
    for (const NamedWindow& window : volume.windows) {
        state.windows.push_back({window.name, window.width, window.level});
    }
    state.suv_per_value = volume.suv_per_value;
    state.minimum = volume.minimum;
    state.maximum = volume.maximum;
    state.gaps = static_cast<std::int64_t>(volume.gap_slabs.size());
    for (const Finding& finding : volume.findings) {
        state.findings.push_back({finding_name(finding.kind), finding.text});
    }
    state.center_mm = numbers(subject.center_mm);
    state.radius_mm = subject.radius_mm;
    state.voxel_to_patient = numbers(volume.voxel_to_patient);
    state.slice_places = volume.slice_places;
    return state;
}

CameraState camera_state(const Session& session) {
    const Camera& camera = session.scene.camera;
    const Size& size = session.scene.size;
    // Without a volume, the state has a camera of an assumed subject, so that its form is the same.
    const bool is_empty = !session.volumes.has_volume() && session.volumes.archive() == nullptr;
    const Subject subject = is_empty ? Subject{glm::dvec3(0), 100} : session.frames.subject();
    const CameraMatrices m =
        camera_matrices(camera, subject, static_cast<double>(size.width) / size.height);
    CameraState state;
    state.azimuth_deg = camera.angles.azimuth_deg;
    state.elevation_deg = camera.angles.elevation_deg;
    state.roll_deg = camera.roll_deg;
    state.zoom = camera.zoom;
    state.pan_mm = {camera.pan_mm.x, camera.pan_mm.y};
    state.patient_to_eye = numbers(m.patient_to_eye);
    state.patient_to_clip = numbers(m.projection * m.patient_to_eye);
    state.center_mm = numbers(subject.center_mm);
    state.radius_mm = subject.radius_mm;
    return state;
}

SurfaceState surface_state(const Session& session, const Surface& surface) {
    const SurfaceReport& report = session.surfaces.report_of(surface.name);
    SurfaceState state;
    state.name = surface.name;
    state.isovalue = surface.isovalue;
    state.color = color_text(surface.color);
    state.visible = surface.visible;
    state.opacity = static_cast<double>(surface.opacity) / full_opacity;
    state.rim = static_cast<double>(surface.rim) / max_rim;
    state.table = enum_name(surface.table);
    state.components = filter_text(surface.components);
    state.triangles = report.triangles;
    state.vertices = report.vertices;
    state.area_mm2 = report.area_mm2;
    state.volume_ml = report.triangles > 0 ? report.volume_mm3 / 1000 : 0;
    state.extraction_ms = report.elapsed_ms;
    state.compared_with = surface.compared_with;
    return state;
}

void add_looks(const Scene& scene, State& state) {
    for (const Light& light : scene.lights) {
        state.lights.push_back({light.azimuth_deg, light.elevation_deg, light.intensity});
    }
    state.material = {scene.material.ambient, scene.material.specular,
                      scene.material.specular_power};
    state.background = color_text(scene.background);
    for (const SceneClip& clip : scene.clips) {
        const glm::dvec4& plane = clip.plane;
        state.clips.push_back({clip.words, {plane.x, plane.y, plane.z, plane.w}});
    }
    for (const ScenePlane& plane : scene.planes) {
        state.planes.push_back({std::string(1, "xyz"[plane.axis]), plane.index});
    }
    state.planes_window = scene.planes_window.width;
    state.planes_level = scene.planes_window.level;
    state.tint_gaps = scene.tint_gaps;
    state.overlay = scene.overlay;
    state.detail = detail_word(scene.detail);
    state.stereo = stereo_word(scene.stereo.mode);
    state.stereo_separation_mm = scene.stereo.separation_mm;
    state.stereo_convergence_mm = scene.stereo.convergence_mm;
}

}  // namespace

std::string sentence_of(const EndNotice& notice) {
    const std::string why = with_stop(notice.why);
    return notice.at.empty() ? fmt::format("This session ends soon: {}", why)
                             : fmt::format("This session ends at {}: {}", notice.at, why);
}

std::string state_text(const Session& session, const StateExtras& extras) {
    const Scene& scene = session.scene;
    State state;
    state.revision = extras.revision;
    if (!extras.busy.empty()) {
        state.busy = extras.busy;
    }
    if (session.volumes.has_volume()) {
        state.volume = volume_state(session);
    }
    if (const ArchiveFacts* archive = session.volumes.archive()) {
        state.archive = archive->file;
    }
    state.camera = camera_state(session);
    state.size = {static_cast<double>(scene.size.width), static_cast<double>(scene.size.height)};
    for (const Surface& surface : scene.surfaces) {
        state.surfaces.push_back(surface_state(session, surface));
    }
    add_looks(scene, state);
    state.undo = session.history.undo_line();
    state.redo = session.history.redo_line();
    state.step = static_cast<std::int64_t>(session.history.step());
    state.machine = {extras.topology, static_cast<std::int64_t>(session.conversation.gps().size()),
                     static_cast<std::int64_t>(session.conversation.renderer_count()),
                     extras.is_recording};
    if (extras.end) {
        state.end = EndState{extras.end->at, extras.end->why, extras.end->open};
    }
    return json_text({{"state", fields_of(state)}});
}

}  // namespace pxpl5::host::serve
