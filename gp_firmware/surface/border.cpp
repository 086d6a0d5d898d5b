#include "gp_firmware/surface/border.hpp"

#include <array>
#include <glm/vec2.hpp>

#include "gp_firmware/surface/edge_vertex.hpp"
#include "gp_firmware/volume/typed.hpp"

namespace pxpl5::gp {

namespace {

/// Values at the corners of a unit square, counter-clockwise from the lowest voxel.
using Square = std::array<double, 4>;

/// Returns the crossing on the side from corner k to the next one, from 0 at corner k to 1. It is
/// the crossing in the mesh, whose edges begin at the lower voxel.
double crossing_of_side(const Square& values, std::size_t k, double isovalue) {
    const std::size_t next = (k + 1) % 4;
    return k < 2 ? crossing(values[k], values[next], isovalue)
                 : 1 - crossing(values[next], values[k], isovalue);
}

/// Returns the area of the polygon through the inside corners and the crossings.
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
            const double part = crossing_of_side(values, k, isovalue);
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

/// Returns whether the inside corners of an ambiguous face are joined, as in
/// SlabWalk::decide_faces().
bool is_joined(const Square& values, double isovalue) {
    const double even = (values[0] - isovalue) * (values[2] - isovalue);
    const double odd = (values[1] - isovalue) * (values[3] - isovalue);
    return values[0] >= isovalue ? even > odd : odd > even;
}

double inside_area(const Square& values, double isovalue, bool decides_faces) {
    const auto inside = [&](std::size_t k) { return values[k] >= isovalue; };
    if (inside(0) != inside(2) || inside(1) != inside(3) || inside(0) == inside(1) ||
        (decides_faces && is_joined(values, isovalue))) {
        return polygon_area(values, isovalue);
    }
    double area = 0;  // Opposite corners have one triangle each.
    for (std::size_t k = 0; k < 4; ++k) {
        if (inside(k)) {
            area += crossing_of_side(values, k, isovalue) *
                    (1 - crossing_of_side(values, (k + 3) % 4, isovalue)) / 2;
        }
    }
    return area;
}

}  // namespace

double inside_of_last_face(const SliceStore& store, int slab, double isovalue, bool decides_faces) {
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
                                isovalue, decides_faces);
        }
    });
    return area * shape.height(slab);
}

}  // namespace pxpl5::gp
