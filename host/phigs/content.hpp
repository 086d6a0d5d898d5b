// The content of an archive: structures executed and flattened to triangles, spheres and lines,
// sorted by material.
#pragma once

#include <compare>
#include <cstdint>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "generated/vocabulary.hpp"
#include "host/phigs/archive.hpp"

namespace pxpl5::host::phigs {

inline constexpr std::size_t max_execute_depth = 64;
inline constexpr std::size_t max_visits = 8'000'000;     ///< Elements, each time it is executed.
inline constexpr std::size_t primitives_per_part = 256;  ///< Parts are what GPs share.

/// How a primitive looks: the frame's list of surfaces.
struct Material {
    Color color;
    bool cull_back = false;
};

struct ContentVertex {
    glm::dvec3 p, normal;  ///< The normal is of unit length.
};
struct ContentSphere {
    glm::dvec3 center;
    double radius;
};
struct ContentLine {
    glm::dvec3 from, to;
};

/// At most primitives_per_part of one material, and a polygon's rest.
struct Part {
    std::size_t material = 0;
    std::vector<ContentVertex> vertices;
    std::vector<std::uint32_t> indices;  ///< 3 per triangle, counter-clockwise from outside.
    std::vector<ContentSphere> spheres;
    std::vector<ContentLine> lines;

    std::size_t primitives() const { return indices.size() / 3 + spheres.size() + lines.size(); }
};

struct Content {
    std::string file;
    std::vector<Material> materials;  ///< In the order of first use; max_surfaces at most.
    std::vector<Part> parts;          ///< Ascending by material.
    glm::dvec3 low{0}, high{0};       ///< Box around all, in the archive's units.
    double radius = 0;                ///< Farthest from the box's middle.
    std::size_t structures = 0, posted = 0;
    std::size_t polygons = 0, triangles = 0, spheres = 0, lines = 0;
    Specular specular;  ///< Gloss of most primitives.
    bool has_specular = false;
    std::vector<std::string> notes;  ///< Differences between the archive and the drawing.

    glm::dvec3 middle() const { return (low + high) * 0.5; }
};

/// Executes the posted structures. Throws RequestError (bad data) naming the place: a structure
/// that is not there or executes itself, a sphere that a matrix makes an ellipsoid, a limit, an
/// archive that draws nothing.
Content flatten(const Archive& archive);

/// Corners 0 .. count-1 as triangles in the polygon's winding; concave polygons are cut by their
/// ears. Always count - 2 triangles, whatever the polygon.
///
/// normal  About which the polygon runs counter-clockwise; only its direction matters.
/// Source  G. Meisters, Polygons have ears, 1975.
std::vector<std::uint32_t> triangulate(const std::vector<glm::dvec3>& corners,
                                       const glm::dvec3& normal);

/// Normal of a polygon that need not be plane, its length twice the area; 0 if it has none.
/// Source M. Newell.
glm::dvec3 newell_normal(const std::vector<glm::dvec3>& corners);

}  // namespace pxpl5::host::phigs
