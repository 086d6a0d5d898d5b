// A PPHIGS archive as it is written: structures and their elements, before anything is executed.
#pragma once

#include <array>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "host/base/command_line.hpp"

namespace pxpl5::host::phigs {

// Limits: an archive is untrusted input.
inline constexpr std::size_t max_file_bytes = std::size_t{64} << 20;
inline constexpr std::size_t max_elements = 2'000'000;  ///< Limit for all structures together.
inline constexpr std::size_t max_name_length = 256;
inline constexpr std::size_t max_polygon_corners = 1024;
inline constexpr std::size_t max_line_points = 65'536;
inline constexpr double max_number = 1e9;

/// Where something stands in the file; both count from 1.
struct Place {
    int line = 1, column = 1;
};

struct Specular {
    std::array<double, 3> rgb{};  ///< 0..255.
    double power = 1;
};

enum class Kind : std::uint8_t { polygon, sphere, line };
inline constexpr std::array<std::string_view, 3> kind_names = {"polygon", "sphere", "line"};

/// color KIND { ... }: what follows of that kind looks so.
struct ColorElement {
    Kind kind = Kind::polygon;
    struct Diffuse {
        Color front, back;
    };
    std::optional<Diffuse> diffuse;
    std::optional<Specular> specular;  ///< Gloss of the front.
};

struct Corner {
    glm::dvec3 p{0};
    glm::dvec3 normal{0};          ///< If the polygon has normals.
    std::optional<Color> diffuse;  ///< Color of this corner alone.
};

struct PolygonElement {
    std::vector<Corner> corners;  ///< 3 at least; counter-clockwise seen from the front.
    bool has_normals = false;
    bool cull_back = false;
    std::optional<Color> diffuse;  ///< Color of both sides, instead of the color set by `color`.
};

struct SphereElement {
    glm::dvec3 center{0};
    double radius = 1;
    Place at;
};

struct LineElement {
    std::vector<glm::dvec3> points;  ///< 2 at least.
};

/// Applied to the coordinates of what follows, before the matrices so far.
struct MatrixElement {
    glm::dmat4 matrix{1.0};
};

struct ExecuteElement {
    std::string name;
    Place at;
};

using Element = std::variant<ColorElement, PolygonElement, SphereElement, LineElement,
                             MatrixElement, ExecuteElement>;

struct Structure {
    std::string name;
    bool posted = false;  ///< Drawn by itself, not only when executed.
    std::vector<Element> elements;
    Place at;
};

struct Archive {
    std::string file;  ///< For messages.
    std::vector<Structure> structures;
    std::size_t translucent = 0;  ///< Colors whose alpha is not 255.
};

/// Takes an archive's text apart.
///
/// file   Its name, for messages.
/// Throws RequestError (bad data): "file:line:column: found X, expected Y".
/// Source The texts of J. Leech's and J. Cohen's writers, 1991 and 1995; see README.md.
Archive parse_archive(std::string_view text, const std::string& file);

/// Reads the file and takes it apart. Throws RequestError.
Archive read_archive(const std::string& path);

/// Throws RequestError (bad data) for a place in a file.
[[noreturn]] void refuse_text(const std::string& file, Place at, const std::string& text);

}  // namespace pxpl5::host::phigs
