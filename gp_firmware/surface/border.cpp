#include "gp_firmware/surface/border.hpp"

#include <array>
#include <cmath>
#include <glm/vec2.hpp>

#include "gp_firmware/volume/typed.hpp"

namespace pxpl5::gp {

namespace {

/// Values at the corners of a unit square, counter-clockwise.
using Square = std::array<double, 4>;

/// Part of the edge from an inside corner to an outside one that is inside; a half where a value is
/// not finite and gives none.
double inside_part(double inside, double outside, double isovalue) {
    const double part = (inside - isovalue) / (inside - outside);
    return std::isfinite(part) ? part : 0.5;
}

/// Area of the polygon through the inside corners and the crossings, in their order.
double polygon_area(const Square& values, double isovalue) {
    constexpr std::array<glm::dvec2, 4> corners = {glm::dvec2{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    std::array<glm::dvec2, 8> points;
    std::size_t count = 0;
    for (std::size_t k = 0; k < 4; ++k) {
        const std::size_t next = (k + 1) % 4;
        const bool here = values[k] >= isovalue, there = values[next] >= isovalue;
        if (here) {
            points[count++] = corners[k];
        }
        if (here != there) {
            const double part = here ? inside_part(values[k], values[next], isovalue)
                                     : 1 - inside_part(values[next], values[k], isovalue);
            points[count++] = corners[k] + part * (corners[next] - corners[k]);
        }
    }
    double doubled = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const glm::dvec2 &p = points[i], &q = points[(i + 1) % count];
        doubled += p.x * q.y - p.y * q.x;
    }
    return doubled / 2;
}

double inside_area(const Square& values, double isovalue) {
    const auto inside = [&](std::size_t k) { return values[k] >= isovalue; };
    if (inside(0) != inside(2) || inside(1) != inside(3) || inside(0) == inside(1)) {
        return polygon_area(values, isovalue);
    }
    double area = 0;  // Two corners across: a triangle at each.
    for (std::size_t k = 0; k < 4; ++k) {
        if (inside(k)) {
            area += inside_part(values[k], values[(k + 1) % 4], isovalue) *
                    inside_part(values[k], values[(k + 3) % 4], isovalue) / 2;
        }
    }
    return area;
}

}  // namespace

double inside_of_last_face(const SliceStore& store, int slab, double isovalue) {
    const VolumeShape& shape = store.shape();
    const auto nx = static_cast<std::size_t>(shape.nx), ny = static_cast<std::size_t>(shape.ny);
    double area = 0;
    with_scalar(shape.type, [&]<class T>(T) {
        const T* lower = typed<T>(store.slice(slab).values) + (nx - 1);
        const T* upper = typed<T>(store.slice(slab + 1).values) + (nx - 1);
        const auto at = [&](const T* column, std::size_t y) {
            return static_cast<double>(column[y * nx]);
        };
        for (std::size_t y = 0; y + 1 < ny; ++y) {
            area += inside_area({at(lower, y), at(lower, y + 1), at(upper, y + 1), at(upper, y)},
                                isovalue);
        }
    });
    return area * shape.height(slab);
}

}  // namespace pxpl5::gp
