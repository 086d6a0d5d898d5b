// Vectors compute what the formulas for one edge and one triangle compute, on every target.
#include <doctest/doctest.h>

#include <cstring>
#include <glm/glm.hpp>
#include <random>

#include "gp_firmware/surface/edge_vertex.hpp"
#include "gp_firmware/surface/marching_cubes.hpp"
#include "isa/contract/vector_target.hpp"
#include "tests/gp_firmware/test_volume.hpp"
#include "tests/random_seed.hpp"

using namespace pxpl5;
using namespace pxpl5::gp;
using pxpl5::test::Gp;
using pxpl5::test::make_volume;
using pxpl5::test::Volume;

namespace {

constexpr CaseRule rules[] = {CaseRule::watertight, CaseRule::lorensen1987, CaseRule::asymptotic};
constexpr Scalar scalars[] = {Scalar::uint8, Scalar::int16, Scalar::uint16, Scalar::float32};

/// Noise with plateaus, where gradients cancel out, in a skewed and uneven grid; floats also have
/// values that are not finite.
Volume rough_volume(pxpl5::test::Size size, Scalar type, std::mt19937& random, bool mirrored) {
    const double infinity = std::numeric_limits<double>::infinity();
    const double odd[] = {std::nan(""), infinity, -infinity};
    Volume volume = make_volume(size, type, [&](int x, int, int) {
        const auto draw = static_cast<unsigned>(random() % 100);
        if (type == Scalar::float32 && draw < 5) return odd[draw % 3];
        return x > size.nx / 2 && draw < 90 ? 4.0 : static_cast<double>(random() % 9);
    });
    volume.shape.minimum = 0;
    volume.shape.maximum = 8;
    volume.shape.voxel_to_patient =
        glm::dmat4(glm::dmat3{mirrored ? -0.7 : 0.7, 0.1, 0.05, 0, 0.9, 0, 0.2, 0, 1.7});
    for (int z = 0; z < size.nz; ++z) volume.shape.slice_places.push_back(z + 0.04 * z * z);
    return volume;
}

bool same_bytes(const auto& a, const auto& b) {
    return a.size() == b.size() &&
           (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(a[0])) == 0);
}

bool same_bits(double a, double b) {
    return std::memcmp(&a, &b, sizeof(a)) == 0;
}

void check_same(const SlabMesh& a, const SlabMesh& b) {
    CHECK(same_bytes(a.vertices, b.vertices));
    CHECK(a.keys == b.keys);
    CHECK(a.indices == b.indices);
    CHECK(a.origins == b.origins);
    CHECK(a.counts.triangles == b.counts.triangles);
    CHECK(a.counts.cells_active == b.counts.cells_active);
    CHECK(a.counts.cells_ambiguous == b.counts.cells_ambiguous);
    CHECK(same_bits(a.counts.area_mm2, b.counts.area_mm2));
    CHECK(same_bits(a.counts.volume_mm3, b.counts.volume_mm3));
}

/// The vertex with this key, from its edge's two voxels alone.
template <class T>
Vertex expected_vertex(const SliceStore& store, std::uint64_t key, double isovalue) {
    const VolumeShape& shape = store.shape();
    const auto nx = static_cast<std::uint64_t>(shape.nx);
    const std::uint64_t voxel = key / 4, axis = key % 4;
    const std::uint64_t within = voxel % shape.slice_voxels();
    const int z_0 = static_cast<int>(voxel / shape.slice_voxels()), z_1 = z_0 + (axis == 2 ? 1 : 0);
    const std::uint64_t other = within + (axis == 0 ? 1 : axis == 1 ? nx : 0);
    const HeldSlice &slice_0 = store.slice(z_0), &slice_1 = store.slice(z_1);
    const EdgeEnds ends{static_cast<double>(typed<T>(slice_0.values)[within]),
                        static_cast<double>(typed<T>(slice_1.values)[other]),
                        slice_0.gradients[within],
                        slice_1.gradients[other],
                        z_factor(shape, z_0),
                        z_factor(shape, z_1)};
    const double t = crossing(ends.value_0, ends.value_1, isovalue);
    glm::dvec3 p(static_cast<double>(within % nx), static_cast<double>(within / nx),
                 shape.place(z_0));
    p[static_cast<int>(axis)] += axis == 2 ? t * shape.height(z_0) : t;
    return {glm::vec3(p), edge_normal(ends, static_cast<float>(t), static_cast<int>(axis), isovalue,
                                      NormalFrame(shape.voxel_to_patient))};
}

}  // namespace

TEST_SUITE("gp/vectors") {
    TEST_CASE("every vector target extracts the same bits") {
        const unsigned seed = pxpl5::test::seed_or(7U);
        CAPTURE(seed);
        std::mt19937 random(seed);
        for (const int nx : {2, 17, 64, 65, 130})
            for (const Scalar type : scalars) {
                const Volume volume = rough_volume({nx, 9, 5}, type, random, nx % 2 == 0);
                const Gp gp(volume, {0, 1});
                for (const CaseRule rule : rules)
                    for (const int slab : gp.store.slabs()) {
                        SlabMesh best;
                        extract_slab(gp.store, slab, 3.75, case_table(rule), best, true);
                        for (const VectorTarget target : pxpl5::isa::available_targets()) {
                            CAPTURE(enum_name(target));
                            SlabMesh mesh;
                            extract_slab(gp.store, slab, 3.75, case_table(rule), mesh, true,
                                         target);
                            check_same(mesh, best);
                        }
                    }
            }
    }

    TEST_CASE("a vertex has the bits that its edge's two voxels give") {
        const unsigned seed = pxpl5::test::seed_or(8U);
        CAPTURE(seed);
        std::mt19937 random(seed);
        std::size_t checked = 0;
        for (const Scalar type : scalars) {
            const Volume volume = rough_volume({131, 12, 6}, type, random, true);
            const Gp gp(volume, {0, 1});
            SlabMesh mesh;
            for (const int slab : gp.store.slabs())
                for (const double isovalue : {3.75, 4.0, 1.0 / 3}) {
                    extract_slab(gp.store, slab, isovalue, case_table(CaseRule::watertight), mesh);
                    with_scalar(type, [&]<class T>(T) {
                        for (std::size_t i = 0; i < mesh.vertices.size(); ++i, ++checked) {
                            const Vertex expected =
                                expected_vertex<T>(gp.store, mesh.keys[i], isovalue);
                            REQUIRE(std::memcmp(&mesh.vertices[i], &expected, sizeof(Vertex)) == 0);
                        }
                    });
                }
        }
        CHECK(checked > 10000);
    }

    TEST_CASE("area and volume are sums over the triangles in their order") {
        const unsigned seed = pxpl5::test::seed_or(9U);
        CAPTURE(seed);
        std::mt19937 random(seed);
        for (const int nx : {2, 5, 40}) {  // A few triangles, and hundreds.
            Volume volume = rough_volume({nx, 7, 4}, Scalar::int16, random, true);
            const auto last = static_cast<std::ptrdiff_t>(nx - 1);
            auto* values = reinterpret_cast<std::int16_t*>(volume.values.data());
            for (std::ptrdiff_t row = 0; row < 7 * 4; ++row) values[row * nx + last] = 0;
            const Gp gp(volume, {0, 1});
            const glm::dmat3 m(volume.shape.voxel_to_patient);
            const glm::dmat3 cofactors(glm::cross(m[1], m[2]), glm::cross(m[2], m[0]),
                                       glm::cross(m[0], m[1]));
            for (const int slab : gp.store.slabs()) {
                SlabMesh mesh;
                extract_slab(gp.store, slab, 3.75, case_table(CaseRule::watertight), mesh);
                double doubled_area = 0, flux = 0;
                for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
                    const auto at = [&](std::size_t corner) {
                        return glm::dvec3(mesh.vertices[mesh.indices[i + corner]].p_voxel);
                    };
                    const glm::dvec3 normal = glm::cross(at(1) - at(0), at(2) - at(0));
                    const glm::dvec3 turned = cofactors * normal;
                    doubled_area += std::sqrt(glm::dot(turned, turned));
                    flux += (at(0).x + at(1).x + at(2).x) * normal.x;
                }
                CHECK(same_bits(mesh.counts.area_mm2, doubled_area / 2));
                // Nothing is inside on the last face.
                CHECK(same_bits(mesh.counts.volume_mm3, glm::determinant(m) * flux / 6 + 0.0));
            }
        }
    }
}
