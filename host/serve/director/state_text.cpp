#include "host/serve/director/state_text.hpp"

#include <fmt/core.h>

#include <glm/gtc/type_ptr.hpp>

#include "host/base/reply.hpp"
#include "host/commands/text/volume_text.hpp"

namespace pxpl5::host::serve {

namespace {

std::vector<double> numbers(const glm::dmat4& matrix) {
    return {glm::value_ptr(matrix), glm::value_ptr(matrix) + 16};
}
std::vector<double> numbers(const glm::dvec3& v) {
    return {v.x, v.y, v.z};
}

std::string colour_text(const Colour& colour) {
    return fmt::format("#{:02x}{:02x}{:02x}", colour.r, colour.g, colour.b);
}

/// As `components` takes it.
std::string filter_text(const ComponentFilter& filter) {
    switch (filter.kind) {
        case ComponentFilter::Kind::largest:
            return "largest";
        case ComponentFilter::Kind::at_least_mm2:
            return fmt::format("min_mm2={:.6g}", filter.least);
        case ComponentFilter::Kind::at_least_ml:
            return fmt::format("min_ml={:.6g}", filter.least);
        case ComponentFilter::Kind::at_point:
            return fmt::format("at {:.1f},{:.1f},{:.1f} mm", filter.p_mm.x, filter.p_mm.y,
                               filter.p_mm.z);
        case ComponentFilter::Kind::all:
            break;
    }
    return "all";
}

Fields volume_fields(const Session& session) {
    const Volume& volume = session.volume();
    std::vector<Fields> findings;
    for (const Finding& finding : volume.findings) {
        findings.push_back(
            {{"kind", std::string(finding_name(finding.kind))}, {"text", finding.text}});
    }
    const Subject subject = session.subject();
    return {
        {"name", volume.name},
        {"source", volume.source},
        {"size", std::vector<double>{static_cast<double>(volume.nx), static_cast<double>(volume.ny),
                                     static_cast<double>(volume.nz)}},
        {"spacing_mm", numbers(spacing_mm(volume))},
        {"modality", volume.modality},
        {"unit", std::string(volume.modality == "CT" ? "HU" : "")},
        {"minimum", volume.minimum},
        {"maximum", volume.maximum},
        {"gaps", static_cast<std::int64_t>(volume.gap_slabs.size())},
        {"findings", findings},
        {"centre_mm", numbers(subject.centre_mm)},
        {"radius_mm", subject.radius_mm},
        {"voxel_to_patient", numbers(volume.voxel_to_patient)},
        {"slice_places", volume.slice_places}};
}

Fields camera_fields(const Session& session) {
    const Camera& camera = session.scene.camera;
    const Size& size = session.scene.size;
    // With nothing loaded, as of something: the page has one form of state.
    const bool is_empty = !session.has_volume() && session.archive() == nullptr;
    const Subject subject = is_empty ? Subject{glm::dvec3(0), 100} : session.subject();
    const CameraMatrices m =
        camera_matrices(camera, subject, static_cast<double>(size.width) / size.height);
    return {{"azimuth_deg", camera.angles.azimuth_deg},
            {"elevation_deg", camera.angles.elevation_deg},
            {"roll_deg", camera.roll_deg},
            {"zoom", camera.zoom},
            {"pan_mm", std::vector<double>{camera.pan_mm.x, camera.pan_mm.y}},
            {"patient_to_eye", numbers(m.patient_to_eye)},
            {"patient_to_clip", numbers(m.projection * m.patient_to_eye)}};
}

Fields surface_state(const Session& session, const Surface& surface) {
    const SurfaceReport& report = session.report_of(surface.name);
    const auto table = static_cast<std::size_t>(surface.table);
    return {{"name", surface.name},
            {"isovalue", surface.isovalue},
            {"color", colour_text(surface.colour)},
            {"visible", surface.visible},
            {"opacity", static_cast<double>(surface.opacity) / opaque},
            {"table", std::string(case_table_names[table])},
            {"components", filter_text(surface.components)},
            {"triangles", report.triangles},
            {"vertices", report.vertices},
            {"area_mm2", report.area_mm2},
            {"volume_ml", report.volume_mm3 / 1000},
            {"extraction_ms", report.elapsed_ms},
            {"compared_with", surface.compared_with}};
}

void add_looks(const Scene& scene, Fields& state) {
    std::vector<Fields> lights, clips;
    for (const Light& light : scene.lights) {
        lights.push_back({{"azimuth_deg", light.azimuth_deg},
                          {"elevation_deg", light.elevation_deg},
                          {"intensity", light.intensity}});
    }
    for (const SceneClip& clip : scene.clips) {
        const glm::dvec4& plane = clip.plane;
        clips.push_back({{"words", clip.words},
                         {"plane", std::vector<double>{plane.x, plane.y, plane.z, plane.w}}});
    }
    state.push_back({"lights", lights});
    state.push_back({"material", Fields{{"ambient", scene.material.ambient},
                                        {"specular", scene.material.specular},
                                        {"power", std::int64_t{scene.material.specular_power}}}});
    state.push_back({"background", colour_text(scene.background)});
    state.push_back({"clips", clips});
    state.push_back({"tint_gaps", scene.tint_gaps});
    state.push_back({"overlay", scene.overlay});
}

Field text_or_null(const char* name, const std::optional<std::string>& text) {
    return text ? Field{name, *text} : Field{name, nullptr};
}

}  // namespace

std::string state_text(const Session& session, const StateExtras& extras) {
    const Scene& scene = session.scene;
    Fields state = {
        {"revision", std::int64_t{extras.revision}},
        text_or_null("busy", extras.busy.empty() ? std::nullopt : std::optional(extras.busy))};
    state.push_back(session.has_volume() ? Field{"volume", volume_fields(session)}
                                         : Field{"volume", nullptr});
    const phigs::Content* archive = session.archive();
    state.push_back(
        text_or_null("archive", archive == nullptr ? std::nullopt : std::optional(archive->file)));
    state.push_back({"camera", camera_fields(session)});
    state.push_back({"size", std::vector<double>{static_cast<double>(scene.size.width),
                                                 static_cast<double>(scene.size.height)}});
    std::vector<Fields> surfaces;
    for (const Surface& surface : scene.surfaces) {
        surfaces.push_back(surface_state(session, surface));
    }
    state.push_back({"surfaces", surfaces});
    add_looks(scene, state);
    state.push_back(text_or_null("undo", session.history.undo_line()));
    state.push_back(text_or_null("redo", session.history.redo_line()));
    state.push_back(
        {"machine", Fields{{"topology", extras.topology},
                           {"gps", static_cast<std::int64_t>(session.gp_count())},
                           {"renderers", static_cast<std::int64_t>(session.renderer_count())},
                           {"recording", extras.is_recording}}});
    return json_text({{"state", state}});
}

}  // namespace pxpl5::host::serve
