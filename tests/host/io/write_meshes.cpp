// Writes the solids in all formats and both conventions of axes, for a reader of others.
//   write_meshes FOLDER
#include <cstdio>

#include "tests/host/io/mesh_solids.hpp"

int main(int argc, char** argv) {
    using namespace pxpl5;
    if (argc != 2) {
        std::fprintf(stderr, "usage: write_meshes FOLDER\n");
        return 64;
    }
    const test::Solid bone = test::tetrahedron();
    const test::Solid skin = test::sphere({-40, 5, 12}, 25, 64, 96);
    host::io::MeshExport mesh;
    mesh.surfaces = {bone.view(), skin.view()};
    mesh.description = "two solids";
    for (const auto& [axes, name] :
         {std::pair(PatientAxes::LPS, "LPS"), std::pair(PatientAxes::RAS, "RAS")}) {
        mesh.axes = axes;
        for (const char* suffix : {"stl", "ply", "obj", "vtp", "glb"}) {
            host::io::write_mesh(std::string(argv[1]) + "/" + name + "." + suffix, mesh);
        }
    }
    return 0;
}
