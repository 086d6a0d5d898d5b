// Binary STL: an 80-byte header, a count, and 50 bytes for each triangle.
#include <fmt/format.h>

#include <array>
#include <cstring>
#include <glm/geometric.hpp>

#include "host/io/mesh/mesh_formats.hpp"

namespace pxpl5::host::io {

namespace {

constexpr std::size_t header_bytes = 80, triangle_bytes = 50;

/// Unit normal of a triangle, counter-clockwise from where it points to; 0 where it has no area.
glm::vec3 facet_normal(const std::array<glm::vec3, 3>& p) {
    const glm::dvec3 a(p[0]);
    const glm::dvec3 across = glm::cross(glm::dvec3(p[1]) - a, glm::dvec3(p[2]) - a);
    const double length = glm::length(across);
    return length > 0 ? glm::vec3(across / length) : glm::vec3(0);
}

}  // namespace

void write_stl(const MeshExport& mesh, PartFile& file) {
    // Readers take what begins with "solid" for text.
    std::string header = fmt::format("binary STL, SPACE={} UNIT=mm, pxpl5", enum_name(mesh.axes));
    header += mesh.description.empty() ? "" : ": " + one_line(mesh.description);
    header.resize(header_bytes, ' ');
    file.write(header);
    const auto count = static_cast<std::uint32_t>(triangle_count(mesh));
    file.write_raw(std::span(&count, 1));
    for (const MeshSurface& surface : mesh.surfaces) {
        for (std::size_t first = 0; first < surface.indices.size(); first += 3) {
            std::array<glm::vec3, 3> corners;
            for (std::size_t corner = 0; corner < 3; ++corner) {
                const std::uint32_t index = surface.indices[first + corner];
                corners[corner] = turned(surface.vertices[index].p_mm, mesh.axes);
            }
            const glm::vec3 normal = facet_normal(corners);
            std::array<char, triangle_bytes> record{};  // Ends with two bytes without a meaning.
            std::memcpy(record.data(), &normal, sizeof normal);
            std::memcpy(record.data() + sizeof normal, corners.data(), sizeof corners);
            file.write({record.data(), record.size()});
        }
    }
}

}  // namespace pxpl5::host::io
