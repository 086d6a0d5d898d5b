// The functions that the rows of the command table run. Arguments are checked before.
#pragma once

#include <string>
#include <vector>

#include "host/base/command_descriptor.hpp"
#include "host/base/command_line.hpp"
#include "host/base/reply.hpp"
#include "host/session/session.hpp"
#include "host/surface/certificate.hpp"

namespace pxpl5::host {

Reply run_load(Session& session, const Arguments& arguments);
Reply run_info(Session& session, const Arguments& arguments);
Reply run_surface(Session& session, const Arguments& arguments);
Reply run_remove(Session& session, const Arguments& arguments);
Reply run_view(Session& session, const Arguments& arguments);
Reply run_light(Session& session, const Arguments& arguments);
Reply run_material(Session& session, const Arguments& arguments);
Reply run_background(Session& session, const Arguments& arguments);
Reply run_size(Session& session, const Arguments& arguments);
Reply run_snapshot(Session& session, const Arguments& arguments);
Reply run_orbit(Session& session, const Arguments& arguments);
Reply run_sweep(Session& session, const Arguments& arguments);
Reply run_stats(Session& session, const Arguments& arguments);
Reply run_presets(Session& session, const Arguments& arguments);
Reply run_clip(Session& session, const Arguments& arguments);
Reply run_antialias(Session& session, const Arguments& arguments);
Reply run_detail(Session& session, const Arguments& arguments);
Reply run_stereo(Session& session, const Arguments& arguments);
Reply run_overlay(Session& session, const Arguments& arguments);
Reply run_tint(Session& session, const Arguments& arguments);
Reply run_pick(Session& session, const Arguments& arguments);
Reply run_histogram(Session& session, const Arguments& arguments);
/// The gray window of the options `window` and `level`, or the one that slices have without them.
GrayWindow window_of(Session& session, const Arguments& arguments);
Reply run_slice(Session& session, const Arguments& arguments);
Reply run_planes(Session& session, const Arguments& arguments);
Reply run_oblique(Session& session, const Arguments& arguments);
Reply run_measure(Session& session, const Arguments& arguments);
Reply run_why(Session& session, const Arguments& arguments);
Reply run_atlas(Session& session, const Arguments& arguments);
Reply run_time(Session& session, const Arguments& arguments);
Reply run_cine(Session& session, const Arguments& arguments);
Reply run_curve(Session& session, const Arguments& arguments);
Reply run_components(Session& session, const Arguments& arguments);
/// Adds the component of `surface` at a point, patient (LPS), to the reply of `pick`.
void add_part(Session& session, const std::string& surface, glm::dvec3 p_mm, Reply& reply);
Reply run_certificate(Session& session, const Arguments& arguments);
Reply run_compare(Session& session, const Arguments& arguments);
/// The certificate of a surface in a file.
Certificate file_certificate(const WeldedFile& file, const Pause& pause = {});
Reply run_export(Session& session, const Arguments& arguments);
/// The files that `export` writes beside a mesh: the certificate, and the colors of an OBJ file.
std::vector<std::string> files_beside_mesh(const std::string& mesh);
Reply run_digest(Session& session, const Arguments& arguments);
Reply run_model(Session& session, const Arguments& arguments);
Reply run_activity(Session& session, const Arguments& arguments);
Reply run_kill(Session& session, const Arguments& arguments);
Reply run_scale(Session& session, const Arguments& arguments);
Reply run_computers(Session& session, const Arguments& arguments);
Reply run_trace(Session& session, const Arguments& arguments);
Reply run_undo(Session& session, const Arguments& arguments);
Reply run_redo(Session& session, const Arguments& arguments);
Reply run_mark(Session& session, const Arguments& arguments);
Reply run_history(Session& session, const Arguments& arguments);
Reply run_play(Session& session, const Arguments& arguments);
Reply run_quit(Session& session, const Arguments& arguments);

// Limits of views and lights, for the table and for the handlers.
inline constexpr double max_angle_deg = 36000, max_place_mm = 1e6;
inline constexpr double min_zoom = 0.05, max_zoom = 100;

/// Options of `model`: the parameters of a machine.
std::vector<Parameter> model_options();

/// Returns `name`, which is empty or names a surface that pictures show. Throws RequestError
/// (usage) for other names, and for surfaces that are hidden or compared.
std::string shown_surface(const Session& session, const std::string& name);
/// The components that the filter selects, in words.
std::string filter_text(const ComponentFilter& filter);
/// The clip planes, as `clip` takes them.
std::vector<std::string> clip_words(const Scene& scene);
/// Why pictures of a surface with slabs that are left out take longer, and what helps.
std::string left_out_text(const SurfaceReport& report);
/// One surface, for people and programs.
std::string surface_text(const Surface& surface, const SurfaceReport& report);
Fields surface_fields(const Surface& surface, const SurfaceReport& report);

}  // namespace pxpl5::host
