// The export requests of the io process: each request is a message, each answer is IoDone.
#pragma once

#include <vector>

#include "host/io/limits.hpp"
#include "ringbus/message.hpp"

namespace pxpl5::host::io {

/// Writes the picture or animation, or answers with the reason of the failure. A failure is never
/// bad data, because the request or the disk is wrong.
bus::schema::IoDoneT export_picture(const bus::schema::ExportPicture& request);

/// Writes the mesh, or answers with the reason of the failure. `text` describes the file;
/// `triangles` counts its triangles.
/// Returns  MeshContent with the surfaces in the file if they were decimated; then IoDone.
std::vector<bus::Payload> export_mesh(const bus::schema::ExportMesh& request);

/// Reads the triangles of a mesh file. Returns MeshContent, unless it fails; then IoDone.
std::vector<bus::Payload> read_mesh_file(const bus::schema::ReadMesh& request);

/// Serves the one ExportPicture that standard input holds, without a ring: for tools that have no
/// machine. Standard input and output hold the bodies of the two messages.
///
/// confines  Confines this process to the request.
/// Returns   the exit code: 0 if an answer was written, 65 if the input is no valid request.
int serve_one_request(const Limits& limits, bool confines);

}  // namespace pxpl5::host::io
