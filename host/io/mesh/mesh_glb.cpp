// glTF 2.0 in one binary file: a chunk of JSON, a chunk of vertices and indices.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "host/io/mesh/mesh_formats.hpp"

namespace pxpl5::host::io {

namespace {

using Json = nlohmann::ordered_json;

// Numbers of the specification.
constexpr std::uint32_t magic = 0x46546C67, version = 2, json_chunk = 0x4E4F534A,
                        binary_chunk = 0x004E4942;
constexpr int type_float = 5126, type_uint32 = 5125, array_buffer = 34962,
              element_array_buffer = 34963;

/// Columns of the matrix that takes millimeters along the axes to glTF's meters: X to the patient's
/// left, Y up, Z to the front, where glTF's models look. No reflection.
Json node_matrix(PatientAxes axes) {
    const double mm = 0.001, front = axes == PatientAxes::LPS ? -mm : mm;
    return {front * -1, 0, 0, 0, 0, 0, front, 0, 0, mm, 0, 0, 0, 0, 0, 1};
}

/// glTF's color factors are linear, ours display-coded.
double linear(std::uint8_t value) {
    const double v = value / 255.0;
    return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}

std::string valid_utf8(const std::string& text) {
    return Json::parse(Json(text).dump(-1, ' ', false, Json::error_handler_t::replace));
}

Json material_of(const MeshSurface& surface) {
    Json color = Json::array();
    for (const std::uint8_t value : surface.color) {
        color.push_back(std::round(linear(value) * 1e6) / 1e6);
    }
    color.push_back(1);
    return {{"name", valid_utf8(surface.name)},
            {"pbrMetallicRoughness",
             {{"baseColorFactor", color}, {"metallicFactor", 0}, {"roughnessFactor", 0.6}}},
            {"doubleSided", true}};  // Surfaces end where the volume ends.
}

/// Smallest and largest coordinates, as the specification wants them of positions.
std::array<Json, 2> bounds_of(const MeshSurface& surface, PatientAxes axes) {
    constexpr float most = std::numeric_limits<float>::max();
    glm::vec3 low(most), high(-most);
    for (const MeshPoint& vertex : surface.vertices) {
        const glm::vec3 p = turned(vertex.p_mm, axes);
        for (int axis = 0; axis < 3; ++axis) {
            low[axis] = std::min(low[axis], p[axis]);
            high[axis] = std::max(high[axis], p[axis]);
        }
    }
    return {Json{low.x, low.y, low.z}, Json{high.x, high.y, high.z}};
}

/// Adds the surface's buffer views, accessors, mesh, material and node.
void add_surface(const MeshExport& mesh, std::size_t index, std::uint64_t& offset, Json& root) {
    const MeshSurface& surface = mesh.surfaces[index];
    const std::uint64_t vertex_bytes = surface.vertices.size() * sizeof(MeshPoint);
    const std::uint64_t index_bytes = surface.indices.size() * sizeof(std::uint32_t);
    const std::array<Json, 2> bounds = bounds_of(surface, mesh.axes);
    const std::size_t views = 2 * index, accessors = 3 * index;
    root["bufferViews"].push_back({{"buffer", 0},
                                   {"byteOffset", offset},
                                   {"byteLength", vertex_bytes},
                                   {"byteStride", sizeof(MeshPoint)},
                                   {"target", array_buffer}});
    root["bufferViews"].push_back({{"buffer", 0},
                                   {"byteOffset", offset + vertex_bytes},
                                   {"byteLength", index_bytes},
                                   {"target", element_array_buffer}});
    offset += vertex_bytes + index_bytes;
    root["accessors"].push_back({{"bufferView", views},
                                 {"componentType", type_float},
                                 {"count", surface.vertices.size()},
                                 {"type", "VEC3"},
                                 {"min", bounds[0]},
                                 {"max", bounds[1]}});
    root["accessors"].push_back({{"bufferView", views},
                                 {"byteOffset", sizeof(MeshPoint::p_mm)},
                                 {"componentType", type_float},
                                 {"count", surface.vertices.size()},
                                 {"type", "VEC3"}});
    root["accessors"].push_back({{"bufferView", views + 1},
                                 {"componentType", type_uint32},
                                 {"count", surface.indices.size()},
                                 {"type", "SCALAR"}});
    const Json attributes = {{"POSITION", accessors}, {"NORMAL", accessors + 1}};
    const std::string name = valid_utf8(surface.name);
    root["meshes"].push_back({{"name", name},
                              {"primitives", Json::array({{{"attributes", attributes},
                                                           {"indices", accessors + 2},
                                                           {"material", index}}})}});
    root["materials"].push_back(material_of(surface));
    root["nodes"][0]["children"].push_back(index + 1);
    root["nodes"].push_back({{"name", name}, {"mesh", index}});
}

/// The JSON chunk; `bytes` becomes the size of the other.
std::string description_of(const MeshExport& mesh, std::uint64_t& bytes) {
    Json root = {
        {"asset",
         {{"version", "2.0"},
          {"generator", "pxpl5"},
          {"extras",
           {{"axes", enum_name(mesh.axes)},
            {"unit", "millimeter"},
            {"of", "vertices; the node above them turns them to meters, Y up, facing +Z"},
            {"description", valid_utf8(mesh.description)}}}}},
        {"scene", 0},
        {"scenes", Json::array({{{"nodes", Json::array({0})}}})},
        {"nodes", Json::array({{{"name", fmt::format("patient, {} millimeters to meters, Y up",
                                                     enum_name(mesh.axes))},
                                {"matrix", node_matrix(mesh.axes)},
                                {"children", Json::array()}}})}};
    bytes = 0;
    for (std::size_t index = 0; index < mesh.surfaces.size(); ++index) {
        add_surface(mesh, index, bytes, root);
    }
    root["buffers"] = Json::array({{{"byteLength", bytes}}});
    std::string text = root.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    return text;
}

}  // namespace

void write_glb(const MeshExport& mesh, PartFile& file) {
    std::uint64_t bytes = 0;
    const std::string text = description_of(mesh, bytes);
    const std::uint64_t whole = 12 + 8 + text.size() + 8 + bytes;
    if (whole > std::numeric_limits<std::uint32_t>::max()) {
        throw MeshError(
            fmt::format("a .glb counts up to 4294967295 bytes, this one needs {}", whole));
    }
    const auto number = [](std::uint64_t value) { return static_cast<std::uint32_t>(value); };
    const std::array<std::uint32_t, 5> head = {magic, version, number(whole), number(text.size()),
                                               json_chunk};
    file.write_raw(std::span<const std::uint32_t>(head));
    file.write(text);
    const std::array<std::uint32_t, 2> second = {number(bytes), binary_chunk};
    file.write_raw(std::span<const std::uint32_t>(second));
    for (const MeshSurface& surface : mesh.surfaces) {
        for (const MeshPoint& vertex : surface.vertices) {
            const std::array vectors = {turned(vertex.p_mm, mesh.axes),
                                        turned(vertex.normal, mesh.axes)};
            file.write_raw(std::span<const glm::vec3>(vectors));
        }
        file.write_raw(surface.indices);
    }
}

}  // namespace pxpl5::host::io
