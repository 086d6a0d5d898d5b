// What each command of the table does. See commands.cpp for their arguments.
#pragma once

#include <string>

#include "host/command_line.hpp"
#include "host/reply.hpp"
#include "host/session.hpp"

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
Reply run_stats(Session& session, const Arguments& arguments);
Reply run_digest(Session& session, const Arguments& arguments);
Reply run_trace(Session& session, const Arguments& arguments);
Reply run_help(Session& session, const Arguments& arguments);
Reply run_quit(Session& session, const Arguments& arguments);

/// What is known of a volume: shape, spacing, orientation, range, notes.
Reply describe_volume(const Volume& volume);

}  // namespace pxpl5::host
