// Binary PLY: a heading of text, vertices with normals and colors, faces with their surface.
#include <fmt/format.h>

#include <array>
#include <cstring>

#include "host/io/mesh/mesh_formats.hpp"

namespace pxpl5::host::io {

namespace {

constexpr std::size_t vertex_bytes = 6 * 4 + 3, face_bytes = 1 + 3 * 4 + 1;

std::string heading(const MeshExport& mesh) {
    std::string text = "ply\nformat binary_little_endian 1.0\ncomment pxpl5\n";
    for (const std::string& note : mesh_notes(mesh)) {
        text += "comment " + note + "\n";
    }
    for (std::size_t index = 0; index < mesh.surfaces.size(); ++index) {
        const MeshSurface& surface = mesh.surfaces[index];
        text += fmt::format("comment surface {} is {}\n", index, one_line(surface.name));
    }
    text += fmt::format("element vertex {}\n", vertex_count(mesh));
    for (const char* name : {"x", "y", "z", "nx", "ny", "nz"}) {
        text += fmt::format("property float {}\n", name);
    }
    for (const char* name : {"red", "green", "blue"}) {
        text += fmt::format("property uchar {}\n", name);
    }
    return text + fmt::format(
                      "element face {}\nproperty list uchar int vertex_indices\n"
                      "property uchar surface\nend_header\n",
                      triangle_count(mesh));
}

}  // namespace

void write_ply(const MeshExport& mesh, PartFile& file) {
    file.write(heading(mesh));
    for (const MeshSurface& surface : mesh.surfaces) {
        for (const MeshPoint& vertex : surface.vertices) {
            const std::array vectors = {turned(vertex.p_mm, mesh.axes),
                                        turned(vertex.normal, mesh.axes)};
            std::array<char, vertex_bytes> record{};
            std::memcpy(record.data(), vectors.data(), sizeof vectors);
            std::memcpy(record.data() + sizeof vectors, surface.color.data(), 3);
            file.write({record.data(), record.size()});
        }
    }
    std::uint32_t before = 0;  // Vertices of the surfaces before this one.
    for (std::size_t index = 0; index < mesh.surfaces.size(); ++index) {
        const MeshSurface& surface = mesh.surfaces[index];
        for (std::size_t first = 0; first < surface.indices.size(); first += 3) {
            const std::array<std::uint32_t, 3> corners = {before + surface.indices[first],
                                                          before + surface.indices[first + 1],
                                                          before + surface.indices[first + 2]};
            std::array<char, face_bytes> record{};
            record[0] = 3;
            std::memcpy(record.data() + 1, corners.data(), sizeof corners);
            record[face_bytes - 1] = static_cast<char>(index);
            file.write({record.data(), record.size()});
        }
        before += static_cast<std::uint32_t>(surface.vertices.size());
    }
}

}  // namespace pxpl5::host::io
