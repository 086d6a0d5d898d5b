// What is asked of the io process's writing side, answered: messages in, IoDone out.
#pragma once

#include "ringbus/message.hpp"

namespace pxpl5::host::io {

/// Writes the picture or animation, or says why not. Never bad data: what is wrong is the request
/// or the disk.
bus::schema::IoDoneT export_picture(const bus::schema::ExportPicture& request);

/// Writes the mesh, or says why not. `text` tells what was written, `triangles` how many.
bus::schema::IoDoneT export_mesh(const bus::schema::ExportMesh& request);

}  // namespace pxpl5::host::io
