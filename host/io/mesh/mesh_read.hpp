// Meshes in: the triangles of STL, PLY, OBJ, VTP and GLB files, also of other programs.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace pxpl5::host::io {

/// Triangles of all surfaces of a file.
struct MeshFile {
    std::vector<glm::vec3> points;       ///< Along the file's axes; GLB in mm, others in its unit.
    std::vector<std::uint32_t> indices;  ///< 3 per triangle.
};

/// Throws MeshError: no such file, another format, a broken file, no triangles.
MeshFile read_mesh(const std::string& path);

/// The file `bytes` as STL, binary or text. Throws MeshError, also for a file that is cut.
/// path  For error texts.
MeshFile read_stl(const std::string& path, std::string_view bytes);

/// The file `bytes` as PLY, binary or text. Throws MeshError, also for a file that is cut.
/// path  For error texts.
MeshFile read_ply(const std::string& path, std::string_view bytes);

/// The file `bytes` as VTK's PolyData in XML: text, base64 or raw, also compressed by zlib.
/// path  For error texts.
MeshFile read_vtp(const std::string& path, std::string_view bytes);

}  // namespace pxpl5::host::io
