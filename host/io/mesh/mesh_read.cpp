// The only file of the program that includes assimp.
#include "host/io/mesh/mesh_read.hpp"

#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

#include "host/base/part_file.hpp"
#include "host/io/mesh/mesh_export.hpp"
#include "host/io/mesh/mesh_polygon.hpp"

namespace pxpl5::host::io {

namespace {

constexpr float mm_per_gltf_unit = 1000;

void add_node(const aiScene& scene, const aiNode& node, const aiMatrix4x4& above, MeshFile& out) {
    const aiMatrix4x4 to_file = above * node.mTransformation;
    // glTF turns the winding of a node that mirrors.
    const bool mirrors = to_file.Determinant() < 0;
    for (unsigned m = 0; m < node.mNumMeshes; ++m) {
        const aiMesh& mesh = *scene.mMeshes[node.mMeshes[m]];
        const auto before = static_cast<std::uint32_t>(out.points.size());
        for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
            const aiVector3D p = to_file * mesh.mVertices[v] * mm_per_gltf_unit;
            out.points.emplace_back(p.x, p.y, p.z);
        }
        for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
            const aiFace& face = mesh.mFaces[f];
            if (face.mNumIndices != 3) continue;
            for (const unsigned corner : {0U, mirrors ? 2U : 1U, mirrors ? 1U : 2U}) {
                out.indices.push_back(before + face.mIndices[corner]);
            }
        }
    }
    for (unsigned child = 0; child < node.mNumChildren; ++child) {
        add_node(scene, *node.mChildren[child], to_file, out);
    }
}

MeshFile read_glb(const std::string& path) {
    Assimp::Importer importer;
    const aiScene* scene = importer.ReadFile(path, aiProcess_Triangulate);
    if (scene == nullptr || scene->mRootNode == nullptr) {
        throw MeshError(fmt::format("{}: cannot be read: {}", path, importer.GetErrorString()));
    }
    MeshFile out;
    add_node(*scene, *scene->mRootNode, aiMatrix4x4(), out);
    return out;
}

/// The vertex that a corner "7", "7/1/3" or "-2" of a face names.
std::uint32_t corner_of(const std::string& path, const char* word, std::size_t vertices) {
    const long number = std::strtol(word, nullptr, 10);
    const long index = number < 0 ? static_cast<long>(vertices) + number : number - 1;
    if (index < 0 || index >= static_cast<long>(vertices)) {
        throw MeshError(fmt::format("{}: a face has vertex {} of {}", path, number, vertices));
    }
    return static_cast<std::uint32_t>(index);
}

/// assimp does not come to an end of OBJ files that are cut in a line.
MeshFile read_obj(const std::string& path, std::istream& stream) {
    MeshFile out;
    std::size_t number = 0;
    for (std::string line; std::getline(stream, line);) {
        ++number;
        std::istringstream words(line);
        std::string word;
        words >> word;
        if (word == "v") {
            glm::vec3& p = out.points.emplace_back();
            for (int axis = 0; axis < 3; ++axis) {
                word.clear();
                words >> word;
                p[axis] =
                    static_cast<float>(number_of(fmt::format("{}: line {}", path, number), word));
            }
        } else if (word == "f") {
            std::vector<std::uint32_t> corners;
            while (words >> word) {
                corners.push_back(corner_of(path, word.c_str(), out.points.size()));
            }
            add_polygon(out, corners);
        }
    }
    return out;
}

}  // namespace

MeshFile read_mesh(const std::string& path) {
    const std::string suffix = suffix_of(path);
    if (const std::string reason = why_unreadable(path); !reason.empty()) {
        throw MeshError(fmt::format("{}: {}", path, reason));
    }
    MeshFile out;
    if (suffix == ".vtp" || suffix == ".stl" || suffix == ".ply") {
        std::ifstream stream(path, std::ios::binary);
        const std::string bytes(std::istreambuf_iterator<char>(stream), {});
        out = suffix == ".vtp"   ? read_vtp(path, bytes)
              : suffix == ".stl" ? read_stl(path, bytes)
                                 : read_ply(path, bytes);
    } else if (suffix == ".obj") {
        std::ifstream stream(path);
        out = read_obj(path, stream);
    } else if (suffix == ".glb") {
        out = read_glb(path);
    } else {
        throw MeshError(fmt::format("{}: suffix is '{}', meshes are .stl, .ply, .obj, .vtp or .glb",
                                    path, suffix));
    }
    if (out.indices.empty()) {
        throw MeshError(path + ": has no triangles");
    }
    if (out.points.size() > max_export_count || out.indices.size() > max_export_count) {
        throw MeshError(fmt::format("{}: has {} vertices and {} corners, at most {} are read", path,
                                    out.points.size(), out.indices.size(), max_export_count));
    }
    const auto is_bad = [](const glm::vec3& p) {
        return !std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z);
    };
    if (std::ranges::any_of(out.points, is_bad)) {
        throw MeshError(path + ": a vertex is not finite");
    }
    return out;
}

}  // namespace pxpl5::host::io
