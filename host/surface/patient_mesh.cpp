#include "host/surface/patient_mesh.hpp"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace pxpl5::host {

namespace {

std::vector<std::uint64_t> numbers(std::size_t count) {
    std::vector<std::uint64_t> keys(count);
    std::iota(keys.begin(), keys.end(), 0U);
    return keys;
}

}  // namespace

void keep_apart(WeldedMesh& mesh, const VolumeGrid& grid) {
    for (std::size_t v = 0; v < mesh.keys.size(); ++v) {
        const EdgePlace edge = edge_place(mesh.keys[v], grid);
        if (edge.axis == 3) continue;
        const int voxel = edge.voxel[static_cast<std::size_t>(edge.axis)];
        const bool is_z = edge.axis == 2;
        const double low = is_z ? grid.place(voxel) : voxel,
                     high = is_z ? grid.place(voxel + 1) : voxel + 1,
                     least = least_from_voxel * (high - low);
        float& p = mesh.p_grid[v][edge.axis];
        p = static_cast<float>(std::clamp(double{p}, low + least, high - least));
    }
}

void move_to_patient(WeldedMesh& mesh, const VolumeGrid& grid) {
    for (glm::vec3& p : mesh.p_grid) {
        p = glm::vec3(grid.p_mm(glm::dvec3(p)));
    }
    mesh.keys = numbers(mesh.keys.size());
    mesh.cells.clear();
    mesh.slabs.clear();
}

VolumeGrid patient_grid() {
    return {};
}

WeldedFile weld(std::span<const glm::vec3> points_mm,
                std::span<const std::array<std::uint32_t, 3>> triangles) {
    constexpr std::uint32_t unused = 0xFFFFFFFF;
    std::vector<std::uint32_t> number(points_mm.size(), unused), order;
    for (const auto& triangle : triangles) {
        for (const std::uint32_t vertex : triangle) {
            if (number[vertex] == unused) order.push_back(vertex);
            number[vertex] = 0;
        }
    }
    const auto place = [&](std::uint32_t vertex) {
        const glm::vec3& p = points_mm[vertex];
        return std::tuple(p.x, p.y, p.z);
    };
    std::ranges::sort(order, {}, place);
    WeldedFile out;
    for (std::size_t i = 0; i < order.size(); ++i) {
        if (i == 0 || place(order[i]) != place(order[i - 1])) {
            out.mesh.p_grid.push_back(points_mm[order[i]]);
        }
        number[order[i]] = static_cast<std::uint32_t>(out.mesh.p_grid.size() - 1);
    }
    for (const auto& [a, b, c] : triangles) {
        if (number[a] == number[b] || number[b] == number[c] || number[c] == number[a]) {
            ++out.collapsed;
        } else {
            out.mesh.triangles.push_back({number[a], number[b], number[c]});
        }
    }
    // A vertex whose triangles have all collapsed is no vertex.
    std::vector<std::uint32_t> kept(out.mesh.p_grid.size(), unused);
    for (const auto& triangle : out.mesh.triangles) {
        for (const std::uint32_t vertex : triangle) kept[vertex] = 0;
    }
    std::uint32_t count = 0;
    for (std::size_t v = 0; v < kept.size(); ++v) {
        if (kept[v] == unused) continue;
        out.mesh.p_grid[count] = out.mesh.p_grid[v];
        kept[v] = count++;
    }
    out.mesh.p_grid.resize(count);
    for (auto& triangle : out.mesh.triangles) {
        for (std::uint32_t& vertex : triangle) vertex = kept[vertex];
    }
    out.mesh.keys = numbers(count);
    return out;
}

}  // namespace pxpl5::host
