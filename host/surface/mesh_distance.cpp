#include "host/surface/mesh_distance.hpp"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <numeric>
#include <vector>

#include "host/surface/components.hpp"

namespace pxpl5::host {

namespace {

using Triangle = std::array<std::uint32_t, 3>;

/// A tree of boxes over triangles, each half as many as the one above.
class BoxTree {
  public:
    BoxTree(std::span<const glm::vec3> vertices, std::span<const Triangle> triangles)
        : vertices_(vertices), triangles_(triangles), order_(triangles.size()) {
        std::iota(order_.begin(), order_.end(), 0U);
        build(0, order_.size());
    }

    /// Square of the distance of `p` from the nearest triangle, or `least` if that is less.
    double nearest_square(const glm::dvec3& p, double least) const {
        std::array<std::size_t, max_depth> waiting{};
        std::size_t count = 1;  // The root.
        while (count > 0) {
            const std::size_t at = waiting[--count];
            const Node& node = nodes_[at];
            const glm::dvec3 gap =
                glm::max(glm::max(glm::dvec3(node.low) - p, p - glm::dvec3(node.high)), 0.0);
            if (glm::dot(gap, gap) >= least) continue;
            if (node.right == 0) {
                for (std::size_t i = node.first; i < node.last; ++i) {
                    const auto& [a, b, c] = triangles_[order_[i]];
                    const glm::dvec3 away =
                        nearest_of_triangle(p, vertices_[a], vertices_[b], vertices_[c]) - p;
                    least = std::min(least, glm::dot(away, away));
                }
                continue;
            }
            // The child on the side of the point comes first.
            const bool is_right = p[node.axis] > node.split;
            waiting[count++] = is_right ? at + 1 : node.right;
            waiting[count++] = is_right ? node.right : at + 1;
        }
        return least;
    }

  private:
    static constexpr std::size_t max_depth = 64, leaf_size = 8;
    struct Node {
        glm::vec3 low{std::numeric_limits<float>::infinity()},
            high{-std::numeric_limits<float>::infinity()};
        std::size_t first = 0, last = 0;
        std::size_t right = 0;  ///< The left child is the next node; 0 for a leaf.
        int axis = 0;
        double split = 0;
    };

    glm::vec3 middle(std::uint32_t triangle) const {
        const auto& [a, b, c] = triangles_[triangle];
        return (vertices_[a] + vertices_[b] + vertices_[c]) / 3.0F;
    }

    void build(std::size_t first, std::size_t last) {
        const std::size_t at = nodes_.size();
        Node node;
        node.first = first;
        node.last = last;
        for (std::size_t i = first; i < last; ++i) {
            for (const std::uint32_t vertex : triangles_[order_[i]]) {
                node.low = glm::min(node.low, vertices_[vertex]);
                node.high = glm::max(node.high, vertices_[vertex]);
            }
        }
        nodes_.push_back(node);
        if (last - first <= leaf_size) return;
        const glm::vec3 size = node.high - node.low;
        const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
        const auto begin = order_.begin();
        const auto half = static_cast<std::ptrdiff_t>((first + last) / 2);
        std::nth_element(begin + static_cast<std::ptrdiff_t>(first), begin + half,
                         begin + static_cast<std::ptrdiff_t>(last),
                         [&](auto a, auto b) { return middle(a)[axis] < middle(b)[axis]; });
        nodes_[at].axis = axis;
        nodes_[at].split = double{middle(order_[static_cast<std::size_t>(half)])[axis]};
        build(first, (first + last) / 2);
        nodes_[at].right = nodes_.size();
        build((first + last) / 2, last);
    }

    std::span<const glm::vec3> vertices_;
    std::span<const Triangle> triangles_;
    std::vector<std::uint32_t> order_;
    std::vector<Node> nodes_;
};

}  // namespace

std::vector<double> distances(std::span<const glm::vec3> points,
                              std::span<const glm::vec3> vertices,
                              std::span<const Triangle> triangles) {
    const BoxTree tree(vertices, triangles);
    std::vector<double> found;
    found.reserve(points.size());
    for (const glm::vec3& p : points) {
        found.push_back(std::sqrt(tree.nearest_square(p, std::numeric_limits<double>::infinity())));
    }
    return found;
}

double farthest_distance(std::span<const glm::vec3> points, std::span<const glm::vec3> vertices,
                         std::span<const Triangle> triangles) {
    const std::vector<double> all = distances(points, vertices, triangles);
    return all.empty() ? 0 : *std::ranges::max_element(all);
}

}  // namespace pxpl5::host
