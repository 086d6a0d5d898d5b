// What `load` says of how a volume is read.
#pragma once

#include "host/base/command_line.hpp"
#include "host/session/session.hpp"

namespace pxpl5::host {

/// The options of load and info: series=, spacing=X,Y,Z, raw=XxYxZ,TYPE[,be][,OFFSET],
/// crop=A:B,C:D,E:F (first and last voxel kept), resample=XxYxZ, resample_mm=X,Y,Z, smooth=MM.
/// Throws RequestError naming the option and both values.
ImportOptions load_options(const Arguments& arguments);

/// Their names, for the table of commands.
std::vector<std::string_view> load_option_names();

}  // namespace pxpl5::host
