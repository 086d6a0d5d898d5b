// Mesh files: a file that is read gives whole triangles of finite vertices, and the certificate of
// the mesh agrees with a count of its edges.
#include <array>
#include <cmath>
#include <map>

#include "host/io/mesh/mesh_export.hpp"
#include "host/io/mesh/mesh_read.hpp"
#include "host/surface/certificate.hpp"
#include "host/surface/patient_mesh.hpp"
#include "tests/fuzz/fuzz.hpp"
#include "tests/fuzz/scratch.hpp"

namespace pxpl5::fuzz {

namespace {

using namespace host;

void check_mesh(const io::MeshFile& file) {
    require(!file.indices.empty() && file.indices.size() % 3 == 0, "whole triangles");
    for (const std::uint32_t index : file.indices) {
        require(index < file.points.size(), "the index of a vertex");
    }
    for (const glm::vec3& p : file.points) {
        require(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z), "finite vertices");
    }
    std::vector<std::array<std::uint32_t, 3>> triangles(file.indices.size() / 3);
    for (std::size_t i = 0; i < file.indices.size(); ++i) {
        triangles[i / 3][i % 3] = file.indices[i];
    }
    const WeldedMesh mesh = weld(file.points, triangles).mesh;
    const Certificate certificate = certify(mesh, patient_grid());
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    for (const auto& corners : mesh.triangles) {
        for (std::size_t k = 0; k < 3; ++k) {
            const auto [a, b] = std::minmax(corners.at(k), corners.at((k + 1) % 3));
            ++edges[{a, b}];
        }
    }
    const auto open =
        std::ranges::count_if(edges, [](const auto& edge) { return edge.second == 1; });
    require(certificate.edges == std::ssize(edges), "the number of edges");
    require(certificate.count(DefectKind::open_edge) == open, "the number of open edges");
    require(certificate.triangles == std::ssize(mesh.triangles), "the number of triangles");
}

}  // namespace

/// Input: a letter of a format and the file.
bool accepts(Input input) {
    static const Scratch scratch;
    static const std::map<char, std::string> names = {
        {'s', "m.stl"}, {'p', "m.ply"}, {'v', "m.vtp"}, {'o', "m.obj"}};
    Bytes bytes(input);
    const auto name = names.find(bytes.take<char>());
    if (name == names.end()) {
        return false;
    }
    const std::string path = scratch.write(name->second, bytes.text());
    try {
        check_mesh(io::read_mesh(path));
        return true;
    } catch (const io::MeshError& error) {
        require(std::string(error.what()).starts_with(path), error.what());
        return false;
    }
}

}  // namespace pxpl5::fuzz
