// Reads the binary PLY files that pxpl5 exports, for peers that draw the same triangles.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace pxpl5::peer {

struct Vertex {
    std::array<float, 3> p_mm;    ///< Patient, LPS.
    std::array<float, 3> normal;  ///< Unit.
};

struct Mesh {
    std::vector<Vertex> vertices;
    std::vector<std::uint32_t> indices;  ///< 3 per triangle.
};

/// A little-endian PLY of triangles whose vertices begin with x y z nx ny nz as floats.
/// Throws std::runtime_error that says what is wrong in it.
Mesh parse_ply(std::string_view data);

/// The same from a file, which an error names.
Mesh read_ply(const std::string& path);

}  // namespace pxpl5::peer
