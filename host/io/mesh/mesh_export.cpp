#include "host/io/mesh/mesh_export.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <optional>

#include "host/io/mesh/mesh_formats.hpp"
#include "host/io/mesh/mesh_simplify.hpp"

namespace pxpl5::host::io {

namespace {

namespace fs = std::filesystem;

void check_surface(const std::string& file, const MeshSurface& surface) {
    if (surface.indices.size() % 3 != 0) {
        throw MeshError(fmt::format("{}: surface {} has {} indices, not a multiple of 3", file,
                                    surface.name, surface.indices.size()));
    }
    for (const std::uint32_t index : surface.indices) {
        if (index >= surface.vertices.size()) {
            throw MeshError(fmt::format("{}: surface {} has vertex index {} of {} vertices", file,
                                        surface.name, index, surface.vertices.size()));
        }
    }
}

void check(const fs::path& path, const MeshExport& mesh) {
    const std::string file = path.string(), suffix = suffix_of(path);
    constexpr std::array known = {".stl", ".ply", ".obj", ".vtp", ".glb"};
    if (std::find(known.begin(), known.end(), suffix) == known.end()) {
        throw MeshError(fmt::format("{}: suffix is '{}', meshes are .stl, .ply, .obj, .vtp or .glb",
                                    file, path.extension().string()));
    }
    if (const std::string wrong = wrong_place(path); !wrong.empty()) {
        throw MeshError(wrong);
    }
    if (mesh.surfaces.empty() || mesh.surfaces.size() > max_surfaces) {
        throw MeshError(fmt::format("{}: {} surfaces, must be 1 to {}", file, mesh.surfaces.size(),
                                    max_surfaces));
    }
    if (!(mesh.error_mm >= 0 && mesh.error_mm <= max_error_mm)) {
        throw MeshError(fmt::format("{}: the error of decimation is {} mm, must be 0 to {}", file,
                                    mesh.error_mm, max_error_mm));
    }
    const bool may_keep_none = mesh.error_mm > 0;
    if (!(mesh.keep >= 0 && mesh.keep <= 1) || (mesh.keep == 0 && !may_keep_none)) {
        throw MeshError(
            fmt::format("{}: share of triangles to keep is {}, must be above 0 and at "
                        "most 1",
                        file, mesh.keep));
    }
    for (const MeshSurface& surface : mesh.surfaces) {
        check_surface(file, surface);
    }
    if (triangle_count(mesh) == 0) {
        throw MeshError(fmt::format("{}: there are no triangles to write", file));
    }
    const std::size_t largest = std::max(vertex_count(mesh), 3 * triangle_count(mesh));
    if (largest > max_export_count) {
        throw MeshError(fmt::format(
            "{}: {} vertices and {} triangles, the formats count {} vertices or corners", file,
            vertex_count(mesh), triangle_count(mesh), max_export_count));
    }
}

/// Writes `mesh` as it is. Returns why that failed, or nothing.
std::string written(const fs::path& path, const MeshExport& mesh) {
    PartFile file(path);
    const std::string suffix = suffix_of(path);
    if (suffix == ".stl") {
        write_stl(mesh, file);
    } else if (suffix == ".ply") {
        write_ply(mesh, file);
    } else if (suffix == ".vtp") {
        write_vtp(mesh, file);
    } else if (suffix == ".glb") {
        write_glb(mesh, file);
    } else {
        const fs::path materials = color_file_of(path);
        PartFile beside(materials);
        write_mtl(mesh, beside);
        write_obj(mesh, materials.filename().string(), file);
        if (std::string failure = file.finish(); !failure.empty()) {
            return failure;  // Neither file appears.
        }
        if (std::string failure = beside.keep(); !failure.empty()) {
            return failure;
        }
    }
    return file.keep();
}

std::string sentence(const fs::path& path, const MeshExport& mesh, std::size_t before,
                     double moved_mm) {
    std::string text = fmt::format("{} triangles, {} vertices, {} millimeters",
                                   triangle_count(mesh), vertex_count(mesh), enum_name(mesh.axes));
    if (mesh.is_decimated() && triangle_count(mesh) == before) {
        text += fmt::format(
            "; not decimated: too few triangles, or the result would be no manifold{}",
            mesh.error_mm > 0 ? fmt::format(", or farther away than {:g} mm", mesh.error_mm) : "");
    } else if (mesh.is_decimated()) {
        text += fmt::format(
            "; decimated from {} triangles, no vertex of which lies more than {:.2g} mm "
            "from the new surface",
            before, moved_mm);
    }
    const std::string suffix = suffix_of(path);
    if (suffix == ".stl") {
        text += "; STL holds no colors and no names";
    } else if (suffix == ".glb") {
        text += ", which its node turns to glTF's meters, Y up";
    } else if (suffix == ".obj") {
        text += fmt::format("; colors in {}", color_file_of(path).filename().string());
    }
    return text;
}

}  // namespace

MeshWritten write_mesh(const std::string& path, const MeshExport& mesh) {
    check(path, mesh);
    MeshExport ready = mesh;  // Copies views; the vertices are not copied.
    std::erase_if(ready.surfaces, [](const MeshSurface& s) { return s.indices.empty(); });
    std::vector<std::pair<std::string, SimplifiedSurface>> simplified;
    double moved_mm = 0;
    if (mesh.is_decimated()) {
        for (MeshSurface& surface : ready.surfaces) {
            simplified.emplace_back(surface.name, simplify(surface, mesh.keep, mesh.error_mm));
            const SimplifiedSurface& now = simplified.back().second;
            moved_mm = std::max(moved_mm, now.moved_mm);
            surface.vertices = now.vertices;
            surface.indices = now.indices;
        }
        std::erase_if(ready.surfaces, [](const MeshSurface& s) { return s.indices.empty(); });
        if (ready.surfaces.empty()) {
            throw MeshError(fmt::format("{}: keeping {} of {} triangles leaves none", path,
                                        mesh.keep, triangle_count(mesh)));
        }
    }
    std::string failure;
    try {
        failure = written(path, ready);
    } catch (const MeshError& error) {
        failure = error.what();
    }
    if (!failure.empty()) {
        throw MeshError(fmt::format("{}: cannot be written: {}", path, failure));
    }
    return {triangle_count(ready), sentence(path, ready, triangle_count(mesh), moved_mm),
            std::move(simplified)};
}

std::vector<std::string> mesh_notes(const MeshExport& mesh) {
    std::vector<std::string> notes = {fmt::format("SPACE={} UNIT=mm", enum_name(mesh.axes)),
                                      mesh.axes == PatientAxes::LPS
                                          ? "x to the patient's left, y posterior, z superior"
                                          : "x to the patient's right, y anterior, z superior"};
    if (!mesh.description.empty()) {
        notes.push_back(one_line(mesh.description));
    }
    return notes;
}

std::string one_line(std::string_view text) {
    std::string line(text);
    std::replace_if(
        line.begin(), line.end(), [](unsigned char c) { return c < ' ' || c == 127; }, ' ');
    return line;
}

std::size_t vertex_count(const MeshExport& mesh) {
    std::size_t count = 0;
    for (const MeshSurface& surface : mesh.surfaces) {
        count += surface.vertices.size();
    }
    return count;
}

std::size_t triangle_count(const MeshExport& mesh) {
    std::size_t count = 0;
    for (const MeshSurface& surface : mesh.surfaces) {
        count += surface.indices.size() / 3;
    }
    return count;
}

}  // namespace pxpl5::host::io
