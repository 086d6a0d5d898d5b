// What each command of the table does. See commands.cpp for their arguments.
#pragma once

#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "host/base/command_line.hpp"
#include "host/base/reply.hpp"
#include "host/session/session.hpp"

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
Reply run_overlay(Session& session, const Arguments& arguments);
Reply run_tint(Session& session, const Arguments& arguments);
Reply run_pick(Session& session, const Arguments& arguments);
Reply run_histogram(Session& session, const Arguments& arguments);
Reply run_slice(Session& session, const Arguments& arguments);
Reply run_measure(Session& session, const Arguments& arguments);
Reply run_why(Session& session, const Arguments& arguments);
Reply run_atlas(Session& session, const Arguments& arguments);
Reply run_components(Session& session, const Arguments& arguments);
Reply run_certificate(Session& session, const Arguments& arguments);
Reply run_compare(Session& session, const Arguments& arguments);
Reply run_export(Session& session, const Arguments& arguments);
Reply run_digest(Session& session, const Arguments& arguments);
Reply run_model(Session& session, const Arguments& arguments);
Reply run_activity(Session& session, const Arguments& arguments);
Reply run_kill(Session& session, const Arguments& arguments);
Reply run_trace(Session& session, const Arguments& arguments);
Reply run_undo(Session& session, const Arguments& arguments);
Reply run_redo(Session& session, const Arguments& arguments);
Reply run_mark(Session& session, const Arguments& arguments);
Reply run_history(Session& session, const Arguments& arguments);
Reply run_play(Session& session, const Arguments& arguments);
Reply run_help(Session& session, const Arguments& arguments);
Reply run_quit(Session& session, const Arguments& arguments);

/// Options that `model` takes: what may be set of a machine.
std::vector<std::string_view> model_option_names();

/// Isovalues beyond this are no floats.
inline constexpr double max_isovalue = std::numeric_limits<float>::max();

/// One surface, for people and programs.
std::string surface_text(const Surface& surface, const SurfaceReport& report);
Fields surface_fields(const Surface& surface, const SurfaceReport& report);

/// "watertight", "lorensen1987" or "asymptotic". Throws RequestError.
CaseTable parse_table(const std::string& text);

}  // namespace pxpl5::host
