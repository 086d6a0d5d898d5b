// VTK's XML PolyData, with its numbers appended as they lie in memory.
#include <fmt/format.h>

#include <array>

#include "host/io/mesh/mesh_formats.hpp"

namespace pxpl5::host::io {

namespace {

/// A block of appended numbers: its place in the heading, and its size.
struct Block {
    std::string_view type, name;
    int components = 1;
    std::uint64_t bytes = 0;
};

/// Text as the codes of its bytes, which is how VTK has texts in its files.
std::string codes(std::string_view text) {
    std::string line;
    for (const char c : text) {
        line += fmt::format("{} ", static_cast<int>(static_cast<unsigned char>(c)));
    }
    return line + "0 ";
}

std::string field(std::string_view name, const std::vector<std::string>& texts) {
    std::string all;
    for (const std::string& text : texts) {
        all += codes(text);
    }
    return fmt::format(
        "<Array type=\"String\" Name=\"{}\" NumberOfTuples=\"{}\" format=\"ascii\">{}</Array>\n",
        name, texts.size(), all);
}

std::string fields(const MeshExport& mesh) {
    std::vector<std::string> names;
    for (const MeshSurface& surface : mesh.surfaces) {
        names.push_back(one_line(surface.name));
    }
    return "<FieldData>\n" + field("SPACE", {std::string(enum_name(mesh.axes))}) +
           field("unit", {"millimeter"}) + field("description", {one_line(mesh.description)}) +
           field("surface names", names) + "</FieldData>\n";
}

/// In the order in which they are appended.
enum BlockIndex : std::size_t { points, normals, colors, surfaces, connectivity, offsets };

std::array<Block, 6> blocks_of(const MeshExport& mesh) {
    const std::uint64_t vertices = vertex_count(mesh), triangles = triangle_count(mesh);
    return {Block{"Float32", "Points", 3, vertices * 12},
            Block{"Float32", "Normals", 3, vertices * 12},
            Block{"UInt8", "color", 3, triangles * 3},
            Block{"UInt8", "surface", 1, triangles},
            Block{"Int32", "connectivity", 1, triangles * 12},
            Block{"Int32", "offsets", 1, triangles * 4}};
}

std::string heading(const MeshExport& mesh, const std::array<Block, 6>& blocks) {
    std::array<std::string, 6> arrays;
    std::uint64_t offset = 0;
    for (std::size_t index = 0; index < blocks.size(); ++index) {
        const Block& block = blocks[index];
        arrays[index] = fmt::format(
            "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" "
            "offset=\"{}\"/>\n",
            block.type, block.name, block.components, offset);
        offset += sizeof(std::uint64_t) + block.bytes;
    }
    return fmt::format(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" "
        "byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<PolyData>\n{}"
        "<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"0\" NumberOfLines=\"0\" NumberOfStrips=\"0\" "
        "NumberOfPolys=\"{}\">\n<Points>\n{}</Points>\n<PointData Normals=\"Normals\">\n{}"
        "</PointData>\n<CellData Scalars=\"color\">\n{}{}</CellData>\n<Polys>\n{}{}</Polys>\n"
        "</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_",
        fields(mesh), vertex_count(mesh), triangle_count(mesh), arrays[points], arrays[normals],
        arrays[colors], arrays[surfaces], arrays[connectivity], arrays[offsets]);
}

template <typename T>
void write_one(const T& value, PartFile& file) {
    file.write_raw(std::span<const T>(&value, 1));
}

void write_points(const MeshExport& mesh, glm::vec3 MeshPoint::*vector, PartFile& file) {
    for (const MeshSurface& surface : mesh.surfaces) {
        for (const MeshPoint& vertex : surface.vertices) {
            write_one(turned(vertex.*vector, mesh.axes), file);
        }
    }
}

/// Once for each triangle what `value` gives for its surface's number.
template <typename Value>
void write_cells(const MeshExport& mesh, Value value, PartFile& file) {
    for (std::size_t index = 0; index < mesh.surfaces.size(); ++index) {
        const auto one = value(index);
        for (std::size_t first = 0; first < mesh.surfaces[index].indices.size(); first += 3) {
            write_one(one, file);
        }
    }
}

void write_triangles(const MeshExport& mesh, PartFile& file) {
    std::uint32_t before = 0;
    for (const MeshSurface& surface : mesh.surfaces) {
        for (const std::uint32_t index : surface.indices) {
            write_one(before + index, file);
        }
        before += static_cast<std::uint32_t>(surface.vertices.size());
    }
}

}  // namespace

void write_vtp(const MeshExport& mesh, PartFile& file) {
    const std::array<Block, 6> blocks = blocks_of(mesh);
    file.write(heading(mesh, blocks));
    write_one(blocks[points].bytes, file);
    write_points(mesh, &MeshPoint::p_mm, file);
    write_one(blocks[normals].bytes, file);
    write_points(mesh, &MeshPoint::normal, file);
    write_one(blocks[colors].bytes, file);
    write_cells(
        mesh, [&](std::size_t index) { return mesh.surfaces[index].color; }, file);
    write_one(blocks[surfaces].bytes, file);
    write_cells(
        mesh, [](std::size_t index) { return static_cast<std::uint8_t>(index); }, file);
    write_one(blocks[connectivity].bytes, file);
    write_triangles(mesh, file);
    write_one(blocks[offsets].bytes, file);
    const auto triangles = static_cast<std::uint32_t>(triangle_count(mesh));
    for (std::uint32_t triangle = 1; triangle <= triangles; ++triangle) {
        write_one(3 * triangle, file);
    }
    file.write("\n</AppendedData>\n</VTKFile>\n");
}

}  // namespace pxpl5::host::io
