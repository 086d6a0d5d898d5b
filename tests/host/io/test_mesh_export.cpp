#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <doctest/doctest.h>
#include <sys/resource.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <csignal>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>

#include "tests/file_bytes.hpp"
#include "tests/host/io/mesh_solids.hpp"
#include "tests/host/io/volume_files.hpp"

using namespace pxpl5;
using namespace pxpl5::host::io;
using namespace pxpl5::test;

namespace {

const glm::vec3 center(-40, 5, 12);
constexpr float radius = 25;

/// The two solids; they must outlive what is made of them.
struct TwoSolids {
    Solid bone = tetrahedron();
    Solid skin = sphere(center, radius, 16, 24);

    MeshExport mesh(PatientAxes axes) const {
        MeshExport mesh;
        mesh.surfaces = {bone.view(), skin.view()};
        mesh.axes = axes;
        mesh.description = "two solids\nwith a second line";
        return mesh;
    }
    std::size_t triangles() const { return (bone.indices.size() + skin.indices.size()) / 3; }
};

std::size_t files_in(const std::string& folder) {
    const std::filesystem::directory_iterator files(folder);
    return static_cast<std::size_t>(std::distance(begin(files), end(files)));
}

/// A file read by assimp: all corners of all triangles in order.
struct ReadBack {
    std::vector<glm::vec3> corners, normals;
    std::vector<std::array<int, 3>> colors;  ///< Per corner, of its vertex or its material.
};

std::array<int, 3> bytes_of_color(float r, float g, float b) {
    return {static_cast<int>(std::lround(r * 255)), static_cast<int>(std::lround(g * 255)),
            static_cast<int>(std::lround(b * 255))};
}

ReadBack read_back(const std::string& path) {
    Assimp::Importer importer;
    const aiScene* scene = importer.ReadFile(path, aiProcess_PreTransformVertices);
    REQUIRE_MESSAGE(scene != nullptr, importer.GetErrorString());
    ReadBack read;
    for (unsigned index = 0; index < scene->mNumMeshes; ++index) {
        const aiMesh& mesh = *scene->mMeshes[index];
        aiColor3D diffuse(0, 0, 0);
        scene->mMaterials[mesh.mMaterialIndex]->Get(AI_MATKEY_COLOR_DIFFUSE, diffuse);
        for (unsigned face = 0; face < mesh.mNumFaces; ++face) {
            REQUIRE(mesh.mFaces[face].mNumIndices == 3);
            for (unsigned corner = 0; corner < 3; ++corner) {
                const unsigned at = mesh.mFaces[face].mIndices[corner];
                const aiVector3D &p = mesh.mVertices[at], &n = mesh.mNormals[at];
                read.corners.emplace_back(p.x, p.y, p.z);
                read.normals.emplace_back(n.x, n.y, n.z);
                const aiColor4D c = mesh.mColors[0] != nullptr
                                        ? mesh.mColors[0][at]
                                        : aiColor4D(diffuse.r, diffuse.g, diffuse.b, 1);
                read.colors.push_back(bytes_of_color(c.r, c.g, c.b));
            }
        }
    }
    return read;
}

/// Into the coordinates of the file: STL, PLY and OBJ as `axes` says, GLB in its own.
glm::vec3 in_file(glm::vec3 v, PatientAxes axes, const std::string& suffix, bool is_place) {
    if (suffix == ".glb") {
        return glm::vec3(v.x, v.z, -v.y) * (is_place ? 0.001F : 1.0F);
    }
    return axes == PatientAxes::LPS ? v : glm::vec3(-v.x, -v.y, v.z);
}

/// The transfer function of the sRGB standard.
double linear(int value) {
    const double v = value / 255.0;
    return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}

/// Checks the file's triangles one by one.
void check_solid(const ReadBack& read, std::size_t first, const Solid& solid, PatientAxes axes,
                 const std::string& suffix) {
    const float tolerance = suffix == ".glb" ? 1e-7F : 0.0F;
    std::array<int, 3> color = {solid.color[0], solid.color[1], solid.color[2]};
    if (suffix == ".glb") {
        for (int& value : color) {
            value = static_cast<int>(std::lround(linear(value) * 255));
        }
    }
    for (std::size_t corner = 0; corner < solid.indices.size(); ++corner) {
        const MeshPoint& vertex = solid.vertices[solid.indices[corner]];
        const glm::vec3 p = in_file(vertex.p_mm, axes, suffix, true);
        const glm::vec3 n = in_file(vertex.normal, axes, suffix, false);
        CHECK(glm::distance(read.corners[first + corner], p) <= tolerance);
        if (suffix != ".stl") {
            CHECK(glm::distance(read.normals[first + corner], n) < 1e-5F);
            CHECK(read.colors[first + corner] == color);
        }
    }
}

nlohmann::json json_of(const std::string& glb) {
    std::uint32_t size = 0;
    std::memcpy(&size, glb.data() + 12, 4);
    return nlohmann::json::parse(glb.substr(20, size));
}

/// The error of write_mesh().
std::string complaint(const std::string& path, const MeshExport& mesh) {
    try {
        write_mesh(path, mesh);
    } catch (const MeshError& error) {
        return error.what();
    }
    return "";
}

}  // namespace

TEST_SUITE("host/io/mesh_export") {
    TEST_CASE("assimp reads every triangle in its place, with its normals and colors") {
        const TemporaryFolder folder;
        const TwoSolids solids;
        for (const PatientAxes axes : {PatientAxes::LPS, PatientAxes::RAS}) {
            for (const std::string suffix : {".stl", ".ply", ".obj", ".glb"}) {
                CAPTURE(suffix);
                const std::string path = folder.file("m" + suffix);
                const MeshWritten written = write_mesh(path, solids.mesh(axes));
                CHECK(written.triangles == solids.triangles());
                const ReadBack read = read_back(path);
                REQUIRE(read.corners.size() == 3 * solids.triangles());
                check_solid(read, 0, solids.bone, axes, suffix);
                check_solid(read, solids.bone.indices.size(), solids.skin, axes, suffix);
            }
        }
    }

    TEST_CASE("triangles turn the same way in both conventions, and facets point outwards") {
        const TemporaryFolder folder;
        const TwoSolids solids;
        for (const PatientAxes axes : {PatientAxes::LPS, PatientAxes::RAS}) {
            const std::string path = folder.file("m.stl");
            write_mesh(path, solids.mesh(axes));
            const ReadBack read = read_back(path);
            std::vector<std::uint32_t> first_solid(12);
            std::iota(first_solid.begin(), first_solid.end(), 0);
            CHECK(signed_volume(read.corners, first_solid) == doctest::Approx(4));
            const glm::vec3 middle = in_file(center, axes, ".stl", true);
            for (std::size_t at = 12; at < read.corners.size(); at += 3) {
                const glm::vec3 face =
                    (read.corners[at] + read.corners[at + 1] + read.corners[at + 2]) / 3.0F;
                CHECK(glm::dot(read.normals[at], glm::normalize(face - middle)) > 0.9F);
                CHECK(glm::length(read.normals[at]) == doctest::Approx(1).epsilon(1e-5));
            }
        }
    }

    TEST_CASE("files state axes, unit and description where they have room") {
        const TemporaryFolder folder;
        const TwoSolids solids;
        for (const PatientAxes axes : {PatientAxes::LPS, PatientAxes::RAS}) {
            const std::string name = axes == PatientAxes::LPS ? "LPS" : "RAS";
            const auto text = [&](const std::string& suffix) {
                write_mesh(folder.file("m" + suffix), solids.mesh(axes));
                return file_bytes(folder.file("m" + suffix));
            };
            const std::string stl = text(".stl");
            CHECK(!stl.starts_with("solid"));
            CHECK(stl.substr(0, 80).find("SPACE=" + name + " UNIT=mm, pxpl5: two solids with") !=
                  std::string::npos);
            CHECK(stl.size() == 84 + 50 * solids.triangles());
            for (const std::string suffix : {".ply", ".obj"}) {
                const std::string mark = suffix == ".ply" ? "comment " : "# ";
                const std::string head = text(suffix);
                CHECK(head.find("\n" + mark + "SPACE=" + name + " UNIT=mm\n") != std::string::npos);
                CHECK(head.find("\n" + mark + "x to the patient's " +
                                (name == "LPS" ? "left, y posterior" : "right, y anterior")) !=
                      std::string::npos);
                CHECK(head.find("\n" + mark + "two solids with a second line\n") !=
                      std::string::npos);
            }
            const nlohmann::json root = json_of(text(".glb"));
            CHECK(root["asset"]["extras"]["axes"] == name);
            CHECK(root["asset"]["extras"]["unit"] == "millimeter");
            CHECK(root["asset"]["extras"]["description"] == "two solids\nwith a second line");
            CHECK(root["nodes"][1]["name"] == "bone");
            CHECK(root["nodes"][2]["name"] == "skin of a ball");
        }
    }

    TEST_CASE("the bounds that glTF asks for are those of its vertices") {
        const TemporaryFolder folder;
        const TwoSolids solids;
        write_mesh(folder.file("m.glb"), solids.mesh(PatientAxes::RAS));
        const nlohmann::json root = json_of(file_bytes(folder.file("m.glb")));
        CHECK(root["accessors"][0]["min"] == nlohmann::json({-12, -23, -30}));
        CHECK(root["accessors"][0]["max"] == nlohmann::json({-10, -20, -26}));
        std::uint64_t end = 0;
        for (const auto& view : root["bufferViews"]) {
            CHECK(view["byteOffset"] == end);
            end += view["byteLength"].get<std::uint64_t>();
        }
        CHECK(root["buffers"][0]["byteLength"] == end);
    }

    TEST_CASE("the same surfaces give the same bytes, and those without triangles none") {
        const TemporaryFolder folder;
        const TwoSolids solids;
        const Solid empty{"nothing", {1, 2, 3}, {}, {}};
        for (const std::string suffix : {".stl", ".ply", ".obj", ".vtp", ".glb"}) {
            CAPTURE(suffix);
            MeshExport mesh = solids.mesh(PatientAxes::LPS);
            write_mesh(folder.file("a" + suffix), mesh);
            const std::string once = file_bytes(folder.file("a" + suffix));
            mesh.surfaces.insert(mesh.surfaces.begin() + 1, empty.view());
            write_mesh(folder.file("a" + suffix), mesh);
            CHECK(file_bytes(folder.file("a" + suffix)) == once);
        }
    }

    TEST_CASE("groups of an OBJ file keep equal and blank names apart") {
        const TemporaryFolder folder;
        const TwoSolids solids;
        MeshExport mesh = solids.mesh(PatientAxes::LPS);
        mesh.surfaces.push_back(solids.bone.view());
        mesh.surfaces.push_back(solids.bone.view());
        mesh.surfaces[3].name = "";
        write_mesh(folder.file("m.obj"), mesh);
        const std::string obj = file_bytes(folder.file("m.obj"));
        const std::string mtl = file_bytes(folder.file("m.mtl"));
        for (const std::string name : {"bone_0", "skin_of_a_ball_1", "bone_2", "_3"}) {
            CHECK(obj.find("g " + name + "\nusemtl " + name + "\n") != std::string::npos);
            CHECK(mtl.find("newmtl " + name + "\n") != std::string::npos);
        }
        CHECK(obj.find("\nmtllib m.mtl\n") != std::string::npos);
    }

    TEST_CASE("a disk without room is an error, whatever the format, and leaves nothing behind") {
        const TemporaryFolder folder;
        const TwoSolids solids;
        rlimit before{};
        getrlimit(RLIMIT_FSIZE, &before);
        std::signal(SIGXFSZ, SIG_IGN);
        const rlimit small{10'000, before.rlim_max};
        for (const std::string suffix : {".stl", ".ply", ".obj", ".vtp", ".glb"}) {
            CAPTURE(suffix);
            setrlimit(RLIMIT_FSIZE, &small);
            const std::string error =
                complaint(folder.file("m" + suffix), solids.mesh(PatientAxes::LPS));
            setrlimit(RLIMIT_FSIZE, &before);
            CHECK(error == folder.file("m" + suffix) + ": cannot be written: File too large");
            CHECK(files_in(folder.file("")) == 0);
        }
    }

    TEST_CASE("what cannot be written is refused with both values") {
        const TemporaryFolder folder;
        const TwoSolids solids;
        const MeshExport mesh = solids.mesh(PatientAxes::LPS);
        const std::string path = folder.file("m.stl");
        CHECK(complaint(folder.file("m.3mf"), mesh).find("suffix is '.3mf', meshes are .stl") !=
              std::string::npos);
        CHECK(complaint(folder.file("no/m.stl"), mesh).find("does not exist") != std::string::npos);
        for (const double keep : {0.0, -0.5, 1.01, std::numeric_limits<double>::quiet_NaN()}) {
            MeshExport wrong = mesh;
            wrong.keep = keep;
            CHECK(complaint(path, wrong).find("share of triangles to keep is") !=
                  std::string::npos);
        }
        Solid broken = tetrahedron();
        broken.indices[5] = 4;
        MeshExport wrong;
        wrong.surfaces = {broken.view()};
        CHECK(complaint(path, wrong).find("surface bone has vertex index 4 of 4 vertices") !=
              std::string::npos);
        broken.indices.resize(4);
        wrong.surfaces = {broken.view()};
        CHECK(complaint(path, wrong).find("has 4 indices") != std::string::npos);
        broken.indices.clear();
        wrong.surfaces = {broken.view()};
        CHECK(complaint(path, wrong).find("no triangles to write") != std::string::npos);
        wrong.surfaces.clear();
        CHECK(complaint(path, wrong).find("0 surfaces, must be 1 to 255") != std::string::npos);
        CHECK(files_in(folder.file("")) == 0);
    }
}
