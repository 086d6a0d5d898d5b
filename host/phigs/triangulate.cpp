#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <numeric>

#include "host/phigs/content.hpp"

namespace pxpl5::host::phigs {

namespace {

struct Flat {
    double x = 0, y = 0;
};

/// Twice the area of a, b, c; positive if they run counter-clockwise.
double turn(const Flat& a, const Flat& b, const Flat& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

bool contains(const Flat& a, const Flat& b, const Flat& c, const Flat& p) {
    return turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0;
}

bool same(const Flat& a, const Flat& b) {
    return a.x == b.x && a.y == b.y;
}

/// The corners without the coordinate along which the normal is longest, still counter-clockwise.
std::vector<Flat> flattened(const std::vector<glm::dvec3>& corners, const glm::dvec3& normal) {
    const glm::dvec3 size = glm::abs(normal);
    const int drop = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const int first = (drop + 1) % 3, second = (drop + 2) % 3;
    std::vector<Flat> flat;
    for (const glm::dvec3& p : corners) {
        flat.push_back(normal[drop] >= 0 ? Flat{p[first], p[second]} : Flat{p[second], p[first]});
    }
    return flat;
}

bool is_ear(const std::vector<Flat>& flat, const std::vector<std::uint32_t>& left, std::size_t i) {
    const std::size_t n = left.size();
    const Flat &a = flat[left[(i + n - 1) % n]], &b = flat[left[i]], &c = flat[left[(i + 1) % n]];
    if (!(turn(a, b, c) > 0)) {
        return false;
    }
    return std::ranges::none_of(left, [&](std::uint32_t k) {
        const Flat& p = flat[k];
        return !same(p, a) && !same(p, b) && !same(p, c) && contains(a, b, c, p);
    });
}

}  // namespace

glm::dvec3 newell_normal(const std::vector<glm::dvec3>& corners) {
    glm::dvec3 sum(0);
    for (std::size_t i = 0; i < corners.size(); ++i) {
        // From the first corner, so that distance from the origin costs no precision.
        const glm::dvec3 p = corners[i] - corners[0],
                         q = corners[(i + 1) % corners.size()] - corners[0];
        sum += glm::cross(p, q);
    }
    return sum;
}

std::vector<std::uint32_t> triangulate(const std::vector<glm::dvec3>& corners,
                                       const glm::dvec3& normal) {
    const std::vector<Flat> flat = flattened(corners, normal);
    std::vector<std::uint32_t> left(corners.size()), indices;
    std::iota(left.begin(), left.end(), 0U);
    while (left.size() > 3) {
        std::size_t ear = 0;
        while (ear < left.size() && !is_ear(flat, left, ear)) {
            ++ear;
        }
        // A polygon that crosses itself may run out of ears: then any corner does.
        ear = ear == left.size() ? 1 : ear;
        const std::size_t n = left.size();
        indices.insert(indices.end(), {left[(ear + n - 1) % n], left[ear], left[(ear + 1) % n]});
        left.erase(left.begin() + static_cast<std::ptrdiff_t>(ear));
    }
    indices.insert(indices.end(), left.begin(), left.end());
    return indices;
}

}  // namespace pxpl5::host::phigs
