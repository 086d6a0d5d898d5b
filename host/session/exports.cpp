#include "host/session/exports.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "host/base/error.hpp"
#include "host/scene/marks_messages.hpp"

namespace pxpl5::host {

namespace {

namespace schema = bus::schema;

/// Room in one message for an animation's pixels, or for meshes.
constexpr std::size_t max_export_bytes = std::size_t{768} << 20;

/// The mesh in millimeters.
flatbuffers::Offset<schema::ExportSurface> to_wire(flatbuffers::FlatBufferBuilder& builder,
                                                   const Surface& surface, const WeldedMesh& mesh,
                                                   const VolumeGrid& grid) {
    schema::MeshVertex* vertices = nullptr;
    const auto vertices_at =
        builder.CreateUninitializedVectorOfStructs(mesh.keys.size(), &vertices);
    for (std::size_t i = 0; i < mesh.keys.size(); ++i) {
        const glm::vec3 p_mm(grid.p_mm(glm::dvec3(mesh.p_grid[i])));
        const glm::vec3& n = mesh.normals[i];
        vertices[i] = schema::MeshVertex(p_mm.x, p_mm.y, p_mm.z, n.x, n.y, n.z);
    }
    const auto indices_at = builder.CreateVector(
        reinterpret_cast<const std::uint32_t*>(mesh.triangles.data()), mesh.triangles.size() * 3);
    const schema::Rgb colour(surface.colour.r, surface.colour.g, surface.colour.b);
    return schema::CreateExportSurface(builder, builder.CreateString(surface.name), &colour,
                                       vertices_at, indices_at);
}

}  // namespace

void Exports::pictures(std::span<const Picture> pictures, const std::string& path,
                       const PictureExtras& extras) {
    schema::ExportPictureT request;
    request.path = path;
    request.width = static_cast<std::uint32_t>(pictures[0].width);
    request.height = static_cast<std::uint32_t>(pictures[0].height);
    request.count = static_cast<std::uint32_t>(pictures.size());
    request.delay_ms = static_cast<std::uint32_t>(extras.delay_ms);
    request.description = extras.description;
    request.marks = marks_message(extras.marks);
    for (const auto& [word, value] : extras.attributes) {
        auto attribute = std::make_unique<schema::AttributeT>();
        attribute->name = word;
        attribute->value = value;
        request.attributes.push_back(std::move(attribute));
    }
    const std::size_t picture_bytes = pictures[0].rgba.size() * 4;
    if (picture_bytes * pictures.size() > max_export_bytes) {
        throw RequestError(
            ExitCode::usage,
            fmt::format("{}: {} pictures of {} x {} have {} bytes, {} are the most; draw fewer or "
                        "smaller ones",
                        path, pictures.size(), pictures[0].width, pictures[0].height,
                        picture_bytes * pictures.size(), max_export_bytes));
    }
    request.rgba.reserve(picture_bytes * pictures.size());
    for (const Picture& picture : pictures) {
        const auto* bytes = reinterpret_cast<const std::uint8_t*>(picture.rgba.data());
        request.rgba.insert(request.rgba.end(), bytes, bytes + picture_bytes);
    }
    io_.write(path, bus::pack(request));
}

MeshExportReport Exports::mesh(const std::string& path, const MeshExport& wish) {
    flatbuffers::FlatBufferBuilder builder(1 << 20);
    std::vector<flatbuffers::Offset<schema::ExportSurface>> surfaces;
    for (const Surface& surface : scene_.surfaces) {
        const bool wanted = wish.surfaces.empty()
                                ? surface.visible && surface.compared_with.empty()
                                : std::ranges::count(wish.surfaces, surface.name) != 0;
        if (!wanted) {
            continue;
        }
        const WeldedMesh mesh = meshes_.fetch_drawn(surface);
        const std::size_t bytes = builder.GetSize() +
                                  mesh.keys.size() * sizeof(schema::MeshVertex) +
                                  mesh.triangles.size() * sizeof(mesh.triangles[0]);
        if (bytes > max_export_bytes) {
            throw RequestError(
                ExitCode::usage,
                fmt::format("{}: the surfaces up to {} have {} bytes, {} are the most in one file; "
                            "name fewer, as surfaces={}, or load with crop= or resample=",
                            path, surface.name, bytes, max_export_bytes, surface.name));
        }
        surfaces.push_back(to_wire(builder, surface, mesh, meshes_.grid()));
    }
    for (const std::string& name : wish.surfaces) {
        meshes_.surface(name);  // Throws for an unknown name.
    }
    if (surfaces.empty()) {
        throw RequestError(ExitCode::usage, path + ": there is no visible surface to write");
    }
    const auto list = builder.CreateVector(surfaces);
    const auto path_at = builder.CreateString(path);
    const auto description_at = builder.CreateString(wish.description);
    const auto axes = wish.ras ? PatientAxes::RAS : PatientAxes::LPS;
    const IoOutcome written = io_.write(
        path,
        bus::finish(builder, schema::CreateExportMesh(builder, path_at, list, axes, description_at,
                                                      static_cast<float>(wish.keep))));
    return {written.triangles, written.text};
}

}  // namespace pxpl5::host
