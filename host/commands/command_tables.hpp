// The rows of the command table, by group.
#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "generated/vocabulary.hpp"
#include "host/commands/commands.hpp"

namespace pxpl5::host {

/// Ends of the names of files that a picture is written to.
inline constexpr std::array<std::string_view, 5> picture_suffixes = {".png", ".tif", ".tiff",
                                                                     ".exr", ".gif"};

/// The values of a switch.
using Words = std::array<std::string_view, 2>;
inline constexpr Words on_off = {"on", "off"}, yes_no = {"yes", "no"};

/// The volumes of a time series that a command runs through.
inline constexpr Parameter first_volume =
    whole_value("from", "N", 1, max_frames, "first volume", "1");
inline constexpr Parameter last_volume = whole_value("to", "N", 1, max_frames, "last volume");

std::vector<Command> volume_commands();
std::vector<Command> series_commands();
std::vector<Command> slice_commands();
std::vector<Command> surface_commands();
std::vector<Command> mesh_commands();
std::vector<Command> view_commands();
std::vector<Command> style_commands();
std::vector<Command> drawing_commands();
std::vector<Command> pixel_commands();
std::vector<Command> picture_commands();
std::vector<Command> machine_commands();
std::vector<Command> session_commands();

}  // namespace pxpl5::host
