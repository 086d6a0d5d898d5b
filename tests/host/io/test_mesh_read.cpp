// Mesh files, of the program and of others, as `certificate FILE` sees them.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <fstream>

#include "host/io/mesh/mesh_read.hpp"
#include "host/surface/certificate.hpp"
#include "host/surface/patient_mesh.hpp"
#include "tests/base64.hpp"
#include "tests/file_bytes.hpp"
#include "tests/gzip.hpp"
#include "tests/host/io/mesh_solids.hpp"
#include "tests/host/io/volume_files.hpp"

using namespace pxpl5::host;
using namespace pxpl5::host::io;
using namespace pxpl5::test;

namespace {

Certificate certificate_of(const MeshFile& file) {
    std::vector<std::array<std::uint32_t, 3>> triangles(file.indices.size() / 3);
    for (std::size_t i = 0; i < file.indices.size(); ++i) {
        triangles[i / 3][i % 3] = file.indices[i];
    }
    return certify(weld(file.points, triangles).mesh, patient_grid());
}

template <typename T>
std::string raw(const std::vector<T>& values) {
    return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

/// Inline arrays in the layout of VTK: the length and the values together, or lengths and blocks
/// apart.
std::string inline_text(const std::string& bytes, bool is_compressed) {
    if (!is_compressed) {
        return base64(raw(std::vector{static_cast<std::uint32_t>(bytes.size())}) + bytes);
    }
    const std::string first = zipped(bytes.substr(0, 16)), rest = zipped(bytes.substr(16));
    // Two blocks of 16 bytes and of what is left: blocks have one size, the last has its own.
    const std::vector<std::uint32_t> lengths = {
        2, 16, static_cast<std::uint32_t>(bytes.size() - 16),
        static_cast<std::uint32_t>(first.size()), static_cast<std::uint32_t>(rest.size())};
    return base64(raw(lengths)) + base64(first + rest);
}

/// A tetrahedron of volume 1/6 in VTK's own layout of a file.
std::string vtp(const std::string& heading, const std::string& format, const std::string& points,
                const std::string& connectivity, const std::string& offsets) {
    const auto array = [&](const char* type, const char* name, const std::string& text) {
        return "<DataArray type=\"" + std::string(type) + "\" Name=\"" + name +
               "\" NumberOfComponents=\"3\" format=\"" + format + "\">\n  " + text +
               "\n</DataArray>\n";
    };
    return "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"0.1\" "
           "byte_order=\"LittleEndian\"" +
           heading +
           ">\n<PolyData>\n<Piece NumberOfPoints=\"4\" NumberOfVerts=\"0\" NumberOfLines=\"0\" "
           "NumberOfStrips=\"0\" NumberOfPolys=\"4\">\n<Points>\n" +
           array("Float32", "Points", points) + "</Points>\n<Polys>\n" +
           array("Int64", "connectivity", connectivity) + array("Int64", "offsets", offsets) +
           "</Polys>\n</Piece>\n</PolyData>\n</VTKFile>\n";
}

std::string complaint_about(const std::string& path) {
    try {
        read_mesh(path);
    } catch (const MeshError& error) {
        return error.what();
    }
    return "";
}

bool has(const std::string& text, const char* part) {
    return text.find(part) != std::string::npos;
}

constexpr const char* text_ply =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
    "property float z\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3";

std::string text_stl() {
    const std::array corners = {"0 0 0", "1 0 0", "0 1 0", "0 0 1"};
    std::string text = "solid a b\n";
    for (const auto& [a, b, c] :
         {std::array{0U, 2U, 1U}, {0U, 1U, 3U}, {0U, 3U, 2U}, {1U, 2U, 3U}}) {
        text += "facet normal 0 0 0\nouter loop\n";
        for (const unsigned corner : {a, b, c}) {
            text += std::string("vertex ") + corners[corner] + "\n";
        }
        text += "endloop\nendfacet\n";
    }
    return text + "endsolid";
}

}  // namespace

TEST_SUITE("host/io/mesh_read") {
    TEST_CASE("each format gives back the closed solids that were written") {
        const TemporaryFolder folder;
        const Solid bone = tetrahedron(), skin = sphere({100, -50, 30}, 20, 30, 40);
        MeshExport mesh;
        mesh.surfaces = {bone.view(), skin.view()};
        for (const std::string suffix : {".stl", ".ply", ".obj", ".vtp", ".glb"}) {
            CAPTURE(suffix);
            write_mesh(folder.file("m" + suffix), mesh);
            const Certificate found = certificate_of(read_mesh(folder.file("m" + suffix)));
            CHECK(found.closed());
            CHECK(found.manifold());
            CHECK(found.oriented());
            CHECK(found.components == 2);
            CHECK(found.triangles ==
                  static_cast<std::int64_t>((bone.indices.size() + skin.indices.size()) / 3));
            const double ball = 4.0 / 3 * 3.14159265 * 8000;
            CHECK(found.volume_mm3 == doctest::Approx(4 + ball).epsilon(0.02));
        }
    }

    TEST_CASE("VTP files of others are read: text, base64, compressed in blocks") {
        const std::vector<float> points = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
        const std::vector<std::int64_t> corners = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3},
                                        ends = {3, 6, 9, 12};
        const auto check = [](const std::string& bytes) {
            const Certificate found = certificate_of(read_vtp("a.vtp", bytes));
            CHECK(found.closed());
            CHECK(found.triangles == 4);
            CHECK(found.volume_mm3 == doctest::Approx(1.0 / 6));
        };
        check(vtp("", "ascii", "0 0 0 1 0 0 0 1 0 0 0 1", "0 2 1 0 1 3 0 3 2 1 2 3", "3 6 9 12"));
        for (const bool is_compressed : {false, true}) {
            check(vtp(is_compressed ? " compressor=\"vtkZLibDataCompressor\"" : "", "binary",
                      inline_text(raw(points), is_compressed),
                      inline_text(raw(corners), is_compressed),
                      inline_text(raw(ends), is_compressed)));
        }
    }

    TEST_CASE("STL and PLY files of others are read: text, big-endian, a heading like text") {
        const TemporaryFolder folder;
        const auto check = [](const std::string& path) {
            const Certificate found = certificate_of(read_mesh(path));
            CHECK(found.closed());
            CHECK(found.triangles == 4);
            CHECK(std::abs(found.volume_mm3) == doctest::Approx(1.0 / 6));
        };
        check(folder.write("a.ply", text_ply));
        check(folder.write("a.stl", text_stl()));
        std::string big =
            "ply\r\nformat binary_big_endian 1.0\r\nelement vertex 4\r\nproperty double x\r\n"
            "property double y\r\nproperty double z\r\nelement face 4\r\n"
            "property list uint8 uint16 vertex_index\r\nend_header\r\n";
        for (const double value : {0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 0., 1.}) {
            std::string raw(reinterpret_cast<const char*>(&value), 8);
            big.append(raw.rbegin(), raw.rend());
        }
        const std::array<std::array<char, 3>, 4> faces = {
            {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
        for (const auto& face : faces) {
            big += '\3';
            for (const char corner : face) {
                big += std::string(1, '\0') + corner;
            }
        }
        check(folder.write("b.ply", big));
    }

    TEST_CASE("STL and PLY files that are cut anywhere are refused") {
        const TemporaryFolder folder;
        const Solid bone = tetrahedron();
        MeshExport mesh;
        mesh.surfaces = {bone.view()};
        write_mesh(folder.file("m.stl"), mesh);
        write_mesh(folder.file("m.ply"), mesh);
        std::string like_text = file_bytes(folder.file("m.stl"));
        like_text.replace(0, 6, "solid ");
        const std::array<std::pair<const char*, std::string>, 5> files = {
            {{"stl", file_bytes(folder.file("m.stl"))},
             {"stl", like_text},
             {"stl", text_stl()},
             {"ply", file_bytes(folder.file("m.ply"))},
             {"ply", text_ply}}};
        for (const auto& [suffix, bytes] : files) {
            CAPTURE(bytes.substr(0, 40));
            const std::string path = folder.file(std::string("cut.") + suffix);
            for (std::size_t size = 0; size < bytes.size(); ++size) {
                CAPTURE(size);
                folder.write(std::string("cut.") + suffix, bytes.substr(0, size));
                CHECK(complaint_about(path).starts_with(path));
            }
            folder.write(std::string("cut.") + suffix, bytes);
            CHECK(complaint_about(path).empty());
        }
    }

    TEST_CASE("words that are no numbers are refused with their line") {
        const TemporaryFolder folder;
        for (const char* word : {"nan", "inf", "1x", "", "1e999"}) {
            CAPTURE(word);
            const std::string path = folder.write(
                "a.obj", std::string("v 1 0 0\nv 0 0 ") + word + "\nv 0 1 0\nf 1 2 3\n");
            CHECK(has(complaint_about(path), "a.obj: line 2: '"));
        }
        std::string text(text_ply);
        text.replace(text.find("0 1 0"), 5, "0 nan 0");
        CHECK(has(complaint_about(folder.write("a.ply", text)), "vertex 2: 'nan'"));
    }

    TEST_CASE("a concave polygon has the area inside it") {
        const TemporaryFolder folder;
        const std::string points = "v 0 0 5\nv 2 0 5\nv 2 2 5\nv 1 0.2 5\nv 0 2 5\n";
        for (const char* face : {"f 1 2 3 4 5", "f 4 5 1 2 3", "f 5 4 3 2 1"}) {
            CAPTURE(face);
            const std::string path = folder.write("a.obj", points + face + "\n");
            CHECK(certificate_of(read_mesh(path)).area_mm2 == doctest::Approx(2.2));
        }
    }

    TEST_CASE("a node of glTF that mirrors turns the winding") {
        const TemporaryFolder folder;
        const Solid bone = tetrahedron();
        MeshExport mesh;
        mesh.surfaces = {bone.view()};
        write_mesh(folder.file("m.glb"), mesh);
        std::string bytes = file_bytes(folder.file("m.glb"));
        const std::string node = "\"mesh\":0", scaled = node + ",\"scale\":[-1,1,1]   ";
        const std::size_t at = bytes.find(node);
        REQUIRE(at != std::string::npos);
        bytes.replace(at, node.size(), scaled);
        const auto added = static_cast<std::uint32_t>(scaled.size() - node.size());
        REQUIRE(added % 4 == 0);
        for (const std::size_t length : {std::size_t{8}, std::size_t{12}}) {
            std::uint32_t value = 0;
            std::memcpy(&value, bytes.data() + length, 4);
            value += added;
            std::memcpy(bytes.data() + length, &value, 4);
        }
        const Certificate found = certificate_of(read_mesh(folder.write("n.glb", bytes)));
        CHECK(found.good());
        CHECK(found.volume_mm3 == doctest::Approx(4));
    }

    TEST_CASE("damaged PolyData are refused before memory is read or claimed") {
        const auto complaint = [](const std::string& bytes) {
            try {
                read_vtp("a.vtp", bytes);
            } catch (const MeshError& error) {
                return std::string(error.what());
            }
            return std::string();
        };
        const std::string points = "0 0 0 1 0 0 0 1 0 0 0 1", corners = "0 2 1 0 1 3 0 3 2 1 2 3";
        CHECK(complaint(vtp("", "ascii", points, corners, "nan 6 9 12")) ==
              "a.vtp: offsets are broken");
        const std::string no_digits(40, '!');
        CHECK(complaint(vtp("", "binary", no_digits, no_digits, no_digits)) ==
              "a.vtp: its data end too early");
        // One block of 2 GiB, in 9 bytes.
        const std::string block =
            base64(raw(std::vector<std::uint32_t>{1, 0x7FFFFFFF, 0, 9})) + base64(zipped("a"));
        CHECK(complaint(vtp(" compressor=\"vtkZLibDataCompressor\"", "binary", block, block,
                            block)) == "a.vtp: its blocks are broken");
        CHECK(complaint(vtp("", "appended", "", "", "") + "<AppendedData encoding=\"raw\">") ==
              "a.vtp: has appended data without their '_'");
    }

    TEST_CASE("what is no mesh is refused by name, and a cut OBJ or VTP file comes to an end") {
        const TemporaryFolder folder;
        CHECK(complaint_about(folder.file("none.stl")).find("none.stl: does not exist") !=
              std::string::npos);
        CHECK(complaint_about(folder.write("a.off", "OFF")).find("suffix is '.off'") !=
              std::string::npos);
        CHECK(complaint_about(folder.write("a.vtp", "<VTKFile type=\"ImageData\">"))
                  .find("PolyData") != std::string::npos);
        const Solid bone = tetrahedron();
        MeshExport mesh;
        mesh.surfaces = {bone.view()};
        for (const std::string suffix : {".obj", ".vtp"}) {
            CAPTURE(suffix);
            write_mesh(folder.file("m" + suffix), mesh);
            const std::string bytes = file_bytes(folder.file("m" + suffix));
            for (std::size_t size = 1; size < bytes.size(); size += 1 + bytes.size() / 40) {
                complaint_about(folder.write("cut" + suffix, bytes.substr(0, size)));
            }
        }
    }
}
