// The mesh formats, one writer each. Meshes come checked, decimated and without empty surfaces.
#pragma once

#include <glm/vec3.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "host/base/part_file.hpp"
#include "host/io/mesh/mesh_export.hpp"

namespace pxpl5::host::io {

void write_stl(const MeshExport& mesh, PartFile& file);
void write_ply(const MeshExport& mesh, PartFile& file);
void write_vtp(const MeshExport& mesh, PartFile& file);

/// Throws MeshError if the surfaces are beyond the 4 GiB that the format can count.
void write_glb(const MeshExport& mesh, PartFile& file);

/// `material_file` is the name by which the mesh refers to its materials.
void write_obj(const MeshExport& mesh, const std::string& material_file, PartFile& file);
void write_mtl(const MeshExport& mesh, PartFile& file);

// Functions that the writers share.

/// A vector in LPS along the mesh's axes. 0 stays 0, never -0.
inline glm::vec3 turned(const glm::vec3& v, PatientAxes axes) {
    return axes == PatientAxes::LPS ? v : glm::vec3(0.0F - v.x, 0.0F - v.y, v.z);
}

/// Notes for readers of the file, one line each: axes, unit, description. 3D Slicer reads the axes
/// from SPACE=LPS or SPACE=RAS.
std::vector<std::string> mesh_notes(const MeshExport& mesh);

/// `text` on one line: control characters become blanks.
std::string one_line(std::string_view text);

std::size_t vertex_count(const MeshExport& mesh);
std::size_t triangle_count(const MeshExport& mesh);

}  // namespace pxpl5::host::io
