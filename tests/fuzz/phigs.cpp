// PPHIGS archives: a text is read and flattened to triangles that are whole, or refused with its
// place.
#include <cmath>

#include "host/base/error.hpp"
#include "host/phigs/content.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace pxpl5::fuzz {

namespace {

using namespace host::phigs;

bool is_finite(const glm::dvec3& p) {
    return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

bool is_unit(const glm::dvec3& n) {
    constexpr double tolerance = 1e-6;
    return std::abs(std::hypot(n.x, n.y, n.z) - 1) < tolerance;
}

void check_inside(const Content& content, const glm::dvec3& p) {
    require(is_finite(p), "a finite coordinate");
    for (int axis = 0; axis < 3; ++axis) {
        require(p[axis] >= content.low[axis] && p[axis] <= content.high[axis],
                "a coordinate in the box of the content");
    }
}

void check_part(const Content& content, const Part& part) {
    require(part.material < content.materials.size(), "the material of a part");
    require(part.indices.size() % 3 == 0, "whole triangles");
    for (const std::uint32_t index : part.indices) {
        require(index < part.vertices.size(), "the index of a vertex");
        check_inside(content, part.vertices[index].p);
    }
    for (const ContentVertex& vertex : part.vertices) {
        require(is_unit(vertex.normal), "the length of a normal");
    }
    for (const ContentSphere& sphere : part.spheres) {
        require(std::isfinite(sphere.radius) && sphere.radius > 0, "a radius above 0");
        check_inside(content, sphere.center);
    }
    for (const ContentLine& line : part.lines) {
        check_inside(content, line.from);
        check_inside(content, line.to);
    }
}

}  // namespace

bool accepts(Input input) {
    const std::string text = Bytes(input).text();
    try {
        const Content content = flatten(parse_archive(text, "a.phigs"));
        std::size_t triangles = 0, spheres = 0, lines = 0, last = 0;
        for (const Part& part : content.parts) {
            require(part.material >= last, "parts ascending by material");
            last = part.material;
            check_part(content, part);
            triangles += part.indices.size() / 3;
            spheres += part.spheres.size();
            lines += part.lines.size();
        }
        require(
            triangles == content.triangles && spheres == content.spheres && lines == content.lines,
            "the counts of primitives");
        require(triangles + spheres + lines > 0, "an archive that draws something");
        return true;
    } catch (const host::RequestError& error) {
        require(error.code == host::ExitCode::bad_data &&
                    std::string(error.what()).starts_with("a.phigs"),
                "an archive's error: " + std::string(error.what()));
        return false;
    }
}

}  // namespace pxpl5::fuzz
