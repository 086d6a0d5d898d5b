// Meshes out: surfaces in patient millimeters -> STL, PLY, OBJ, VTP, GLB.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "generated/vocabulary.hpp"

namespace pxpl5::host::io {

/// Vertices, and corners of triangles: all formats count them in 31 bits.
inline constexpr std::size_t max_export_count = 0x7FFFFFFF;

/// Thrown for a mesh that cannot be written. `what` names the file and the reason.
struct MeshError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

struct MeshPoint {
    glm::vec3 p_mm;    ///< Patient, LPS.
    glm::vec3 normal;  ///< Unit, out of the inside.
};

struct MeshSurface {
    std::string name;
    std::array<std::uint8_t, 3> color{};  ///< Display-coded (sRGB) red, green, blue.
    std::span<const MeshPoint> vertices;
    std::span<const std::uint32_t> indices;  ///< 3 per triangle, counter-clockwise from outside.
};

struct MeshExport {
    std::vector<MeshSurface> surfaces;  ///< 1..max_surfaces; those without triangles: none.
    /// Half a turn about the third axis lies between LPS and RAS: triangles keep their winding.
    PatientAxes axes = PatientAxes::LPS;
    std::string description;  ///< Goes into the file where its format has room.
    /// Share of the triangles that decimation leaves; 1: all, 0: as few as error_mm allows.
    double keep = 1;
    double error_mm = 0;  ///< Decimation leaves no vertex farther from the surface; 0: no limit.

    bool is_decimated() const { return keep < 1; }
};

/// A surface whose vertices are its own.
struct SimplifiedSurface {
    std::vector<MeshPoint> vertices;  ///< Some of the surface's own, in their order.
    std::vector<std::uint32_t> indices;
    double moved_mm = 0;  ///< No vertex of the surface before lies farther from this one.
};

struct MeshWritten {
    std::uint64_t triangles = 0;  ///< In the file.
    std::string text;             ///< One sentence about the file: counts, axes, losses.
    /// The surfaces in the file if they were decimated, with their names; else empty.
    std::vector<std::pair<std::string, SimplifiedSurface>> decimated = {};
};

/// Writes the surfaces to `path`, in the format of its suffix. The file appears whole or not at
/// all. The same surfaces give the same bytes.
///
/// stl   Binary; one list of all triangles, facet normals, no colors; axes and unit in the header.
/// ply   Binary; one list, normals and colors by vertex, the surface's number by face.
/// obj   A group and a material for each surface, in a .mtl file beside it.
/// vtp   VTK's PolyData; normals by point, color and surface by cell, axes and unit as field data.
/// glb   glTF 2.0; a node and a material for each surface. The vertices are in millimeters along
///       `axes`; the node above them turns them to glTF's meters, Y up, patient facing +Z.
/// Throws MeshError.
MeshWritten write_mesh(const std::string& path, const MeshExport& mesh);

}  // namespace pxpl5::host::io
