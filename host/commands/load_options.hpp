// Options of `load` for reading a volume.
#pragma once

#include "host/base/command_descriptor.hpp"
#include "host/session/session.hpp"

namespace pxpl5::host {

/// The options of load and info: series=, frame=N, spacing=X,Y,Z, orientation=ABC, origin=X,Y,Z,
/// raw=XxYxZ,TYPE[,be][,OFFSET], crop=A:B,C:D,E:F (first and last voxel kept), resample=XxYxZ,
/// resample_mm=X,Y,Z, smooth=MM, gradient=KERNEL, read=READER. Throws RequestError naming the
/// option and both values.
ImportOptions load_options(const Arguments& arguments);

/// The same options, for the table of commands.
std::vector<Parameter> load_option_list();

}  // namespace pxpl5::host
