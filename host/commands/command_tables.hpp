// The rows of the command table, by group.
#pragma once

#include <vector>

#include "host/commands/commands.hpp"

namespace pxpl5::host {

std::vector<Command> volume_commands();
std::vector<Command> surface_commands();
std::vector<Command> mesh_commands();
std::vector<Command> view_commands();
std::vector<Command> style_commands();
std::vector<Command> pixel_commands();
std::vector<Command> picture_commands();
std::vector<Command> machine_commands();
std::vector<Command> session_commands();

}  // namespace pxpl5::host
