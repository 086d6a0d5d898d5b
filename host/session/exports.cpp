#include "host/session/exports.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <glm/geometric.hpp>
#include <utility>

#include "host/base/error.hpp"
#include "host/scene/marks_messages.hpp"
#include "host/surface/certificate.hpp"
#include "host/surface/export/border_cap.hpp"
#include "host/surface/export/plane_cut.hpp"
#include "host/surface/mesh_distance.hpp"
#include "host/volume/reduced.hpp"

namespace pxpl5::host {

namespace {

namespace schema = bus::schema;

/// Room in one message for an animation's pixels, or for meshes.
constexpr std::size_t max_export_bytes = std::size_t{768} << 20;

flatbuffers::Offset<schema::ExportSurface> to_wire(flatbuffers::FlatBufferBuilder& builder,
                                                   const Surface& surface, const WeldedMesh& mesh) {
    schema::MeshVertex* vertices = nullptr;
    const auto vertices_at =
        builder.CreateUninitializedVectorOfStructs(mesh.keys.size(), &vertices);
    for (std::size_t i = 0; i < mesh.keys.size(); ++i) {
        const glm::vec3 &p_mm = mesh.p_grid[i], &n = mesh.normals[i];
        vertices[i] = schema::MeshVertex(p_mm.x, p_mm.y, p_mm.z, n.x, n.y, n.z);
    }
    const auto indices_at = builder.CreateVector(
        reinterpret_cast<const std::uint32_t*>(mesh.triangles.data()), mesh.triangles.size() * 3);
    const schema::Rgb color(surface.color.r, surface.color.g, surface.color.b);
    return schema::CreateExportSurface(builder, builder.CreateString(surface.name), &color,
                                       vertices_at, indices_at);
}

WeldedFile welded(const schema::ExportSurface& surface) {
    std::vector<glm::vec3> points;
    points.reserve(surface.vertices()->size());
    for (const schema::MeshVertex* v : *surface.vertices()) {
        points.emplace_back(v->x(), v->y(), v->z());
    }
    static_assert(sizeof(std::array<std::uint32_t, 3>) == 3 * sizeof(std::uint32_t));
    const auto* triangles =
        reinterpret_cast<const std::array<std::uint32_t, 3>*>(surface.indices()->data());
    return weld(points, {triangles, surface.indices()->size() / 3});
}

/// Replaces the surfaces of the report by the decimated surfaces, which the file contains.
void take_decimated(const schema::MeshContent& content, MeshExportReport& report) {
    const std::vector<FileSurface> whole = std::exchange(report.surfaces, {});
    for (const auto* surface : *content.surfaces()) {
        FileSurface now{surface->name()->str(), welded(*surface), surface->vertices()->size()};
        const auto before = std::ranges::find(whole, now.name, &FileSurface::name);
        if (now.file.mesh.triangles.empty()) {
            report.empty.push_back(now.name);
            continue;
        }
        if (before != whole.end()) {
            now.smoothing = before->smoothing;
            now.moved_mm = farthest_distance(before->file.mesh.p_grid, now.file.mesh.p_grid,
                                             now.file.mesh.triangles);
            now.components_before = certify(before->file.mesh, patient_grid()).components;
        }
        report.surfaces.push_back(std::move(now));
    }
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

Exports::ReadyMesh Exports::ready_for_file(const Surface& surface, const MeshExport& wish) {
    const VolumeGrid grid = meshes_.grid();
    const Pause pause = meshes_.pause_of(surface);
    ReadyMesh ready;
    WeldedMesh& mesh = ready.simplified.mesh;
    if (wish.detail == 0) {
        mesh = meshes_.fetch_drawn(surface);
        keep_apart(mesh, grid);
    } else {
        ready.simplified = meshes_.fetch_simplified(surface, wish.detail);
    }
    if (wish.smoothing > 0) {
        ready.smoothing = smooth_mesh(mesh, grid, wish.smoothing, pause);
    }
    if (wish.cap) {
        require_all_voxels(meshes_.volumes().volume(), "closing a surface at the border");
        cap_at_border(mesh, meshes_.volumes().volume(), surface.isovalue);
        pause();
    }
    move_to_patient(mesh, grid);
    const glm::dmat3 steps(grid.voxel_to_patient);
    const double least_mm =
        2 * least_from_voxel *
        std::min({glm::length(steps[0]), glm::length(steps[1]), glm::length(steps[2])});
    for (const SceneClip& clip : scene_.clips) {
        cut_by_plane(mesh, clip.plane / glm::length(glm::dvec3(clip.plane)), least_mm, wish.cap);
        pause();
    }
    return ready;
}

WeldedFile Exports::read_mesh(const std::string& path) {
    schema::ReadMeshT request;
    request.path = path;
    const IoOutcome read = io_.read(path, bus::pack(request));
    const auto* content = read.content ? read.content->as<schema::MeshContent>() : nullptr;
    if (content == nullptr || content->surfaces()->size() != 1) {
        throw RequestError(ExitCode::bad_data,
                           fmt::format("{}: the io process answered with {} meshes instead of one",
                                       path, content == nullptr ? 0 : content->surfaces()->size()));
    }
    return welded(*content->surfaces()->Get(0));
}

MeshExportReport Exports::mesh(const std::string& path, const MeshExport& wish) {
    flatbuffers::FlatBufferBuilder builder(1 << 20);
    MeshExportReport report;
    std::vector<flatbuffers::Offset<schema::ExportSurface>> surfaces;
    for (const Surface& surface : scene_.surfaces) {
        const bool wanted = wish.surfaces.empty()
                                ? surface.visible && surface.compared_with.empty()
                                : std::ranges::count(wish.surfaces, surface.name) != 0;
        if (!wanted) {
            continue;
        }
        const ReadyMesh ready = ready_for_file(surface, wish);
        const WeldedMesh& mesh = ready.simplified.mesh;
        if (mesh.triangles.empty()) {
            report.empty.push_back(surface.name);
            continue;
        }
        report.surfaces.push_back({surface.name, weld(mesh.p_grid, mesh.triangles),
                                   static_cast<std::int64_t>(mesh.keys.size())});
        if (wish.detail > 0) {
            report.surfaces.back().within_mm = ready.simplified.moved_mm;
        }
        report.surfaces.back().smoothing = ready.smoothing;
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
        surfaces.push_back(to_wire(builder, surface, mesh));
    }
    for (const std::string& name : wish.surfaces) {
        meshes_.surface(name);  // Throws for an unknown name.
    }
    if (surfaces.empty()) {
        throw RequestError(ExitCode::usage,
                           report.empty.empty()
                               ? path + ": there is no visible surface to write"
                               : fmt::format("{}: nothing to write: {} without triangles; choose "
                                             "another isovalue, or `clip off`",
                                             path, fmt::join(report.empty, ", ")));
    }
    const auto list = builder.CreateVector(surfaces);
    const auto path_at = builder.CreateString(path);
    const auto description_at = builder.CreateString(wish.description);
    const auto axes = wish.ras ? PatientAxes::RAS : PatientAxes::LPS;
    const IoOutcome written = io_.write(
        path, bus::finish(builder,
                          schema::CreateExportMesh(builder, path_at, list, axes, description_at,
                                                   static_cast<float>(wish.keep), wish.error_mm)));
    report.triangles = written.triangles;
    report.text = written.text;
    if (written.content) {
        take_decimated(*written.content->as<schema::MeshContent>(), report);
    }
    return report;
}

}  // namespace pxpl5::host
