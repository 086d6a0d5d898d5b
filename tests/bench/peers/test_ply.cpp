// The reader of the meshes that peers draw.
#include <doctest/doctest.h>

#include <cstring>
#include <string>

#include "tests/bench/peers/ply.hpp"

using namespace pxpl5;

namespace {

template <class T>
void put(std::string& data, T value) {
    char bytes[sizeof value];
    std::memcpy(bytes, &value, sizeof value);
    data.append(bytes, sizeof value);
}

/// One triangle over three vertices with a color each, in the form that `export` writes.
std::string one_triangle(std::int32_t last_index,
                         const std::string& format = "binary_little_endian",
                         unsigned char corners = 3) {
    std::string data = "ply\nformat " + format + " 1.0\ncomment by hand\nelement vertex 3\n";
    for (const char* name : {"x", "y", "z", "nx", "ny", "nz"}) {
        data += std::string("property float ") + name + "\n";
    }
    data +=
        "property uchar red\nelement face 1\nproperty list uchar int vertex_indices\n"
        "property uchar surface\nend_header\n";
    for (int vertex = 0; vertex < 3; ++vertex) {
        for (int k = 0; k < 6; ++k) {
            put(data, static_cast<float>(10 * vertex + k));
        }
        put(data, static_cast<unsigned char>(200));
    }
    put(data, corners);
    for (const std::int32_t index : {0, 1, last_index}) {
        put(data, index);
    }
    put(data, static_cast<unsigned char>(0));
    return data;
}

}  // namespace

TEST_CASE("vertices and triangles are read, what else they carry is passed over") {
    const peer::Mesh mesh = peer::parse_ply(one_triangle(2));
    REQUIRE(mesh.vertices.size() == 3);
    CHECK(mesh.vertices[1].p_mm == std::array<float, 3>{10, 11, 12});
    CHECK(mesh.vertices[2].normal == std::array<float, 3>{23, 24, 25});
    CHECK(mesh.indices == std::vector<std::uint32_t>{0, 1, 2});
}

TEST_CASE("a mesh that cannot be drawn is refused with the reason") {
    CHECK_THROWS_WITH(peer::parse_ply("solid"), "not a PLY file");
    CHECK_THROWS_WITH(peer::parse_ply(one_triangle(2, "ascii")), "format ascii is not understood");
    CHECK_THROWS_WITH(peer::parse_ply(one_triangle(3)), "a triangle names vertex 3 of 3");
    CHECK_THROWS_WITH(peer::parse_ply(one_triangle(2, "binary_little_endian", 4)),
                      "has a face that is no triangle");
    const std::string whole = one_triangle(2);
    CHECK_THROWS_WITH(peer::parse_ply(whole.substr(0, whole.size() - 1)),
                      "ends before its last element");
    CHECK_THROWS_WITH(peer::read_ply("/nowhere.ply"), "/nowhere.ply: not a PLY file");
}
