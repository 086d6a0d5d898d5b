#include "host/surface/export/plane_cut.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <map>
#include <unordered_map>

namespace pxpl5::host {

namespace {

using Triangle = std::array<std::uint32_t, 3>;

class Cut {
  public:
    Cut(WeldedMesh& mesh, const glm::dvec4& plane) : mesh_(mesh), plane_(plane) {}

    void run(double least, bool closes) {
        measure(least);
        std::vector<Triangle> kept;
        for (const Triangle& triangle : mesh_.triangles) {
            add_kept_part(triangle, kept);
        }
        mesh_.triangles = std::move(kept);
        if (closes) close();
        drop_unused_vertices();
        mesh_.cells.clear();
        mesh_.slabs.clear();
    }

  private:
    void measure(double least) {
        const glm::dvec3 normal(plane_);
        for (glm::vec3& p : mesh_.p_grid) {
            double distance = glm::dot(normal, glm::dvec3(p)) + plane_.w;
            if (std::abs(distance) < least) {
                const double moved = distance < 0 ? -least : least;
                p = glm::vec3(glm::dvec3(p) + normal * (moved - distance));
                distance = moved;
            }
            distances_.push_back(distance);
        }
    }

    bool keeps(std::uint32_t vertex) const { return distances_[vertex] >= 0; }

    /// The vertex where an edge crosses the plane: the same one for both of its triangles.
    std::uint32_t crossing(std::uint32_t a, std::uint32_t b) {
        const auto [low, high] = std::minmax(a, b);
        const auto next = static_cast<std::uint32_t>(mesh_.p_grid.size());
        const auto [at, is_new] = crossings_.emplace(std::uint64_t{low} << 32 | high, next);
        if (is_new) {
            add_between(low, high, distances_[low] / (distances_[low] - distances_[high]));
            distances_.push_back(0);
        }
        return at->second;
    }

    /// A new vertex on the way from `a` to `b`.
    void add_between(std::uint32_t a, std::uint32_t b, double share) {
        const auto between = [&](const glm::vec3& p, const glm::vec3& q) {
            return glm::mix(glm::dvec3(p), glm::dvec3(q), share);
        };
        const glm::dvec3 normal = between(mesh_.normals[a], mesh_.normals[b]);
        const double length = glm::length(normal);
        mesh_.keys.push_back(mesh_.keys.size());
        mesh_.p_grid.emplace_back(between(mesh_.p_grid[a], mesh_.p_grid[b]));
        mesh_.normals.push_back(length > 0 ? glm::vec3(normal / length) : mesh_.normals[a]);
    }

    void add_kept_part(const Triangle& triangle, std::vector<Triangle>& kept) {
        const auto count = std::ranges::count_if(triangle, [&](auto v) { return keeps(v); });
        if (count == 3) kept.push_back(triangle);
        if (count == 0 || count == 3) return;
        // From the vertex that is alone on its side, so that the two others follow it.
        std::size_t alone = 0;
        while (keeps(triangle[alone]) != (count == 1)) ++alone;
        const std::uint32_t a = triangle[alone], b = triangle[(alone + 1) % 3],
                            c = triangle[(alone + 2) % 3];
        const std::uint32_t ab = crossing(a, b), ca = crossing(c, a);
        if (count == 1) {
            kept.push_back({a, ab, ca});
            next_.emplace(ca, ab);
        } else {
            kept.push_back({ab, b, c});
            kept.push_back({ab, c, ca});
            next_.emplace(ab, ca);
        }
    }

    std::vector<std::vector<std::uint32_t>> take_loops() {
        std::vector<std::vector<std::uint32_t>> loops;
        while (!next_.empty()) {
            const std::uint32_t first = next_.begin()->first;
            std::vector<std::uint32_t> loop;
            std::uint32_t at = first;
            for (auto edge = next_.find(at); edge != next_.end(); edge = next_.find(at)) {
                loop.push_back(at);
                at = edge->second;
                next_.erase(edge);
            }
            if (at == first && loop.size() > 2) loops.push_back(std::move(loop));
        }
        return loops;
    }

    void close() {
        // Two directions in the plane that turn counter-clockwise seen from the side cut off.
        const glm::dvec3 outwards = -glm::dvec3(plane_), size = glm::abs(outwards);
        const glm::dvec3 least = size.x <= size.y && size.x <= size.z ? glm::dvec3(1, 0, 0)
                                 : size.y <= size.z                   ? glm::dvec3(0, 1, 0)
                                                                      : glm::dvec3(0, 0, 1);
        const glm::dvec3 right = glm::normalize(glm::cross(least, outwards)),
                         up = glm::cross(outwards, right);
        std::vector<glm::dvec2> points;
        points.reserve(mesh_.p_grid.size());
        for (const glm::vec3& p : mesh_.p_grid) {
            points.emplace_back(glm::dot(right, glm::dvec3(p)), glm::dot(up, glm::dvec3(p)));
        }
        const LoopTriangles cover = triangulate_loops(points, take_loops());
        for (const auto& [a, b, share] : cover.added) {
            add_between(a, b, share);
        }
        mesh_.triangles.insert(mesh_.triangles.end(), cover.triangles.begin(),
                               cover.triangles.end());
    }

    void drop_unused_vertices() {
        constexpr std::uint32_t unused = 0xFFFFFFFF;
        std::vector<std::uint32_t> number(mesh_.p_grid.size(), unused);
        for (const Triangle& triangle : mesh_.triangles) {
            for (const std::uint32_t vertex : triangle) number[vertex] = 0;
        }
        std::uint32_t count = 0;
        for (std::size_t v = 0; v < number.size(); ++v) {
            if (number[v] == unused) continue;
            mesh_.p_grid[count] = mesh_.p_grid[v];
            mesh_.normals[count] = mesh_.normals[v];
            mesh_.keys[count] = count;
            number[v] = count++;
        }
        mesh_.p_grid.resize(count);
        mesh_.normals.resize(count);
        mesh_.keys.resize(count);
        for (Triangle& triangle : mesh_.triangles) {
            for (std::uint32_t& vertex : triangle) vertex = number[vertex];
        }
    }

    WeldedMesh& mesh_;
    glm::dvec4 plane_;
    std::vector<double> distances_;  ///< Distance of each vertex from the plane.
    std::unordered_map<std::uint64_t, std::uint32_t> crossings_;
    std::map<std::uint32_t, std::uint32_t> next_;  ///< Edges of the cover along the cut.
};

}  // namespace

void cut_by_plane(WeldedMesh& mesh, const glm::dvec4& plane, double least, bool closes) {
    Cut(mesh, plane).run(least, closes);
}

}  // namespace pxpl5::host
