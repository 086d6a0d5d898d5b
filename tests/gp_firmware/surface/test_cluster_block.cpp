// Simplified surfaces: closed, within the bound, and equal for any machine.
#include <doctest/doctest.h>

#include <array>
#include <cstring>
#include <glm/geometric.hpp>
#include <map>

#include "gp_firmware/surface/cluster_block.hpp"
#include "tests/gp_firmware/surface/mesh_check.hpp"
#include "tests/gp_firmware/test_volume.hpp"
#include "tests/random_seed.hpp"

using namespace pxpl5;
using namespace pxpl5::gp;
using pxpl5::test::extract_all;
using pxpl5::test::make_volume;
using pxpl5::test::Volume;
using pxpl5::test::WeldedMesh;

namespace {

struct Simplified {
    std::vector<SlabMesh> blocks;
    double bound_mm = 0;
    std::size_t triangles = 0;
};

Simplified simplify(const Volume& volume, std::span<const SlabMesh> slabs, int side) {
    Simplified simplified;
    for (std::size_t first = 0; first < slabs.size(); first += block_slabs) {
        const std::size_t count = std::min<std::size_t>(block_slabs, slabs.size() - first);
        const double moved = cluster_block(volume.shape, slabs.subspan(first, count), {}, side,
                                           simplified.blocks.emplace_back());
        simplified.bound_mm = std::max(simplified.bound_mm, moved);
        simplified.triangles += simplified.blocks.back().indices.size() / 3;
    }
    return simplified;
}

/// Edges that triangles do not use equally often in both directions: in a face of the volume, and
/// elsewhere.
struct Openings {
    std::size_t border = 0, elsewhere = 0;
};

Openings openings(const WeldedMesh& mesh, const VolumeShape& shape) {
    std::map<std::uint64_t, int> net;
    for (const auto& use : pxpl5::test::edge_uses(mesh)) net[use.ends] += use.forward ? 1 : -1;
    Openings found;
    for (const auto& [ends, sum] : net) {
        if (sum == 0) continue;
        const unsigned faces = pxpl5::test::border_faces(mesh.keys[ends >> 32], shape) &
                               pxpl5::test::border_faces(mesh.keys[ends & 0xFFFFFFFFU], shape);
        ++(faces != 0 ? found.border : found.elsewhere);
    }
    return found;
}

using Corners = std::array<glm::dvec3, 3>;

std::vector<Corners> triangles_mm(const WeldedMesh& mesh, const VolumeShape& shape) {
    std::vector<Corners> triangles;
    for (std::size_t i = 0; i < mesh.indices.size(); ++i) {
        const glm::dvec3 p(mesh.vertices[mesh.indices[i]].p_voxel);
        if (i % 3 == 0) triangles.emplace_back();
        triangles.back()[i % 3] = glm::dmat3(shape.voxel_to_patient) * p;
    }
    return triangles;
}

double distance_to_segment(glm::dvec3 p, glm::dvec3 a, glm::dvec3 b) {
    const glm::dvec3 ab = b - a;
    const double length = glm::dot(ab, ab);
    const double t = length > 0 ? std::clamp(glm::dot(p - a, ab) / length, 0.0, 1.0) : 0.0;
    return glm::length(p - a - t * ab);
}

double distance(glm::dvec3 p, const Corners& t) {
    double least = std::min({distance_to_segment(p, t[0], t[1]), distance_to_segment(p, t[1], t[2]),
                             distance_to_segment(p, t[2], t[0])});
    const glm::dvec3 n = glm::cross(t[1] - t[0], t[2] - t[0]);
    bool above = glm::dot(n, n) > 0;
    for (std::size_t i = 0; i < 3 && above; ++i)
        above = glm::dot(glm::cross(t[(i + 1) % 3] - t[i], p - t[i]), n) >= 0;
    return above ? std::min(least, std::abs(glm::dot(p - t[0], n)) / glm::length(n)) : least;
}

/// The largest distance of the corners and centers of `from` (every `step`th) from `to`.
double farthest(const std::vector<Corners>& from, const std::vector<Corners>& to,
                std::size_t step) {
    double most = 0;
    for (std::size_t i = 0; i < from.size(); i += step) {
        const Corners& t = from[i];
        for (const glm::dvec3 p : {t[0], t[1], t[2], (t[0] + t[1] + t[2]) / 3.0}) {
            double least = std::numeric_limits<double>::infinity();
            for (const Corners& exact : to) least = std::min(least, distance(p, exact));
            most = std::max(most, least);
        }
    }
    return most;
}

/// A bumpy ball, cut by the volume's faces if `radius` is large. The slices are not evenly spaced.
Volume ball(double radius) {
    Volume volume = make_volume({30, 27, 41}, Scalar::float32, [&](int x, int y, int z) {
        return radius - std::hypot(x - 14.3, y - 13.1, z - 19.7) + 0.7 * std::sin(x + 2 * y - z);
    });
    volume.shape.voxel_to_patient[0][0] = 0.7;
    volume.shape.voxel_to_patient[1][1] = 0.9;
    volume.shape.voxel_to_patient[2] = {0.2, 0, 1.3, 0};
    for (int z = 0; z < 41; ++z) volume.shape.slice_places.push_back(z + 0.3 * std::sin(z));
    return volume;
}

Volume noise() {
    std::mt19937 random(pxpl5::test::seed_or(11U));
    return make_volume({23, 19, 37}, Scalar::uint16,
                       [&](int, int, int) { return double(random() % 11); });
}

}  // namespace

TEST_SUITE("gp/cluster_block") {
    TEST_CASE("a simplified surface is open only in the volume's faces, and its seams fit") {
        for (const Volume& volume : {ball(11), ball(22), noise()}) {
            for (const CaseRule rule : {CaseRule::watertight, CaseRule::asymptotic}) {
                const auto exact =
                    extract_all(volume, volume.shape.type == Scalar::uint16 ? 5 : 0, rule);
                const auto open = openings(pxpl5::test::weld(exact), volume.shape);
                for (const int side : {2, 4, 8}) {
                    const Simplified got = simplify(volume, exact, side);
                    const WeldedMesh mesh = pxpl5::test::weld(got.blocks);
                    CAPTURE(side);
                    CHECK(got.triangles > 0);
                    CHECK(mesh.mismatches == 0);
                    CHECK(mesh.bad_indices == 0);
                    const Openings after = openings(mesh, volume.shape);
                    CHECK(after.elsewhere == 0);
                    CHECK((after.border > 0) == (open.border > 0));
                }
            }
        }
    }

    TEST_CASE("vertices with the key of a face lie in that face") {
        const Volume volume = ball(22);
        for (const SlabMesh& block : simplify(volume, extract_all(volume, 0), 4).blocks) {
            for (std::size_t i = 0; i < block.vertices.size(); ++i) {
                const unsigned faces = pxpl5::test::border_faces(block.keys[i], volume.shape);
                const glm::vec3 p = block.vertices[i].p_voxel;
                if ((faces & 1U) != 0) CHECK(p.x == 0);
                if ((faces & 2U) != 0) CHECK(p.x == 29);
                if ((faces & 4U) != 0) CHECK(p.y == 0);
                if ((faces & 8U) != 0) CHECK(p.y == 26);
                if ((faces & 16U) != 0) CHECK(p.z == float(volume.shape.place(0)));
                if ((faces & 32U) != 0) CHECK(p.z == float(volume.shape.place(40)));
            }
        }
    }

    TEST_CASE("the distance from the exact surface is at most the bound") {
        for (const Volume& volume : {ball(11), ball(22), noise()}) {
            const auto exact = extract_all(volume, volume.shape.type == Scalar::uint16 ? 5 : 0);
            const auto exact_mm = triangles_mm(pxpl5::test::weld(exact), volume.shape);
            const glm::dmat3 to_mm(volume.shape.voxel_to_patient);
            for (const int side : {2, 4, 8}) {
                const Simplified got = simplify(volume, exact, side);
                const auto fewer = triangles_mm(pxpl5::test::weld(got.blocks), volume.shape);
                const double most = farthest(fewer, exact_mm, 1 + fewer.size() / 25);
                CAPTURE(side);
                CHECK(most > 0);
                CHECK(most <= got.bound_mm + 1e-5);
                // A cell with its faces is `side` voxels wide, and slices are at most 1.3 apart.
                CHECK(got.bound_mm <= side * glm::length(to_mm * glm::dvec3(1, 1, 1.3)));
                CHECK(got.triangles < exact_mm.size());
            }
        }
    }

    TEST_CASE("the number of GPs that extracted the slabs changes no bit") {
        Volume volume = ball(22);
        const Simplified one = simplify(volume, extract_all(volume, 0), 4);
        for (const int slabs_per_set : {1, 3, 16}) {
            volume.shape.slabs_per_set = slabs_per_set;
            const Simplified got =
                simplify(volume, extract_all(volume, 0, CaseRule::watertight, 3), 4);
            CHECK(got.bound_mm == one.bound_mm);
            for (std::size_t b = 0; b < one.blocks.size(); ++b) {
                const SlabMesh &l = got.blocks[b], &r = one.blocks[b];
                CHECK(l.indices == r.indices);
                CHECK(l.keys == r.keys);
                REQUIRE(l.vertices.size() == r.vertices.size());
                CHECK(std::memcmp(l.vertices.data(), r.vertices.data(),
                                  l.vertices.size() * sizeof(Vertex)) == 0);
            }
        }
    }
}
