// STL: binary with a count, or text from "solid" to "endsolid". assimp accepts files that are cut.
#include <fmt/format.h>

#include <cstring>

#include "host/io/mesh/mesh_export.hpp"
#include "host/io/mesh/mesh_polygon.hpp"

namespace pxpl5::host::io {

namespace {

constexpr std::size_t head_bytes = 84, facet_bytes = 50, normal_bytes = 12;
constexpr std::string_view stl_blanks = " \t\r\n\f\v";

MeshFile read_binary(std::string_view bytes, std::uint32_t count) {
    MeshFile out;
    for (std::size_t facet = 0; facet < count; ++facet) {
        std::array<glm::vec3, 3> corners;
        std::memcpy(corners.data(), bytes.data() + head_bytes + facet * facet_bytes + normal_bytes,
                    sizeof corners);
        for (const glm::vec3& corner : corners) {
            out.indices.push_back(static_cast<std::uint32_t>(out.points.size()));
            out.points.push_back(corner);
        }
    }
    return out;
}

MeshFile read_text(const std::string& path, std::string_view text) {
    MeshFile out;
    bool is_ended = false;
    const auto next = [&text] {
        text.remove_prefix(std::min(text.find_first_not_of(stl_blanks), text.size()));
        const std::string_view word = text.substr(0, text.find_first_of(stl_blanks));
        text.remove_prefix(word.size());
        return word;
    };
    for (std::string_view word = next(); !word.empty(); word = next()) {
        if (word == "solid") is_ended = false;
        if (word == "endsolid") is_ended = true;
        if (word == "solid" || word == "endsolid") {
            text.remove_prefix(std::min(text.find('\n'), text.size()));  // A name.
        }
        if (word == "vertex") {
            const std::string where = fmt::format("{}: vertex {}", path, out.points.size());
            const double x = number_of(where, next()), y = number_of(where, next()),
                         z = number_of(where, next());
            out.indices.push_back(static_cast<std::uint32_t>(out.points.size()));
            out.points.emplace_back(x, y, z);
        }
    }
    if (!is_ended || out.points.size() % 3 != 0) {
        throw MeshError(
            fmt::format("{}: has {} vertices and no 'endsolid' after the last triangle. "
                        "The file may be truncated.",
                        path, out.points.size()));
    }
    return out;
}

}  // namespace

MeshFile read_stl(const std::string& path, std::string_view bytes) {
    std::uint32_t count = 0;
    if (bytes.size() >= head_bytes) std::memcpy(&count, bytes.data() + head_bytes - 4, 4);
    const std::size_t size = head_bytes + facet_bytes * count;
    const bool is_text = bytes.starts_with("solid") && bytes.size() != size;
    if (!is_text && (bytes.size() < head_bytes || bytes.size() < size)) {
        throw MeshError(
            fmt::format("{}: has {} bytes, but {} triangles of binary STL need {}. The "
                        "file may be truncated.",
                        path, bytes.size(), count, size));
    }
    return is_text ? read_text(path, bytes) : read_binary(bytes, count);
}

}  // namespace pxpl5::host::io
