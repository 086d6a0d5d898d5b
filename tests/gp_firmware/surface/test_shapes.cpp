// Surfaces whose area, volume and genus mathematics knows.
#include <doctest/doctest.h>

#include <glm/glm.hpp>
#include <limits>
#include <numbers>

#include "tests/gp_firmware/surface/mesh_check.hpp"
#include "tests/gp_firmware/test_volume.hpp"

using namespace pxpl5;
using namespace pxpl5::gp;
using pxpl5::test::Certificate;
using pxpl5::test::certify;
using pxpl5::test::extract_all;
using pxpl5::test::make_volume;
using pxpl5::test::Size;
using pxpl5::test::Volume;

namespace {

constexpr double pi = std::numbers::pi;

/// A float volume of field(p_patient_mm) at the voxels that `voxel_to_patient` places.
template <class Field>
Volume place(Size size, const glm::dmat4& voxel_to_patient, Field field) {
    Volume volume = make_volume(size, Scalar::float32, [&](int x, int y, int z) {
        return field(glm::dvec3(voxel_to_patient * glm::dvec4(x, y, z, 1)));
    });
    volume.shape.voxel_to_patient = voxel_to_patient;
    return volume;
}

/// Steps of the given columns in mm, the grid's middle voxel at the patient's origin plus shift.
glm::dmat4 grid(Size size, const glm::dmat3& steps, glm::dvec3 shift) {
    const glm::dvec3 middle(size.nx / 2, size.ny / 2, size.nz / 2);
    glm::dmat4 m(steps);
    m[3] = glm::dvec4(shift - steps * middle, 1);
    return m;
}

glm::dmat3 anisotropic() {
    return {0.9, 0, 0, 0, 1.1, 0, 0, 0, 2.1};
}
glm::dmat3 mirrored() {
    return {-0.9, 0, 0, 0, 1.1, 0, 0, 0, 2.1};
}

/// Rotated, with sheared slices, as a tilted gantry makes them.
glm::dmat3 tilted() {
    const double c = std::cos(0.4), s = std::sin(0.4);
    return glm::dmat3{c, s, 0, -s, c, 0, 0.3, 0.5, 1.9};
}

/// The greatest angle in degrees between the normals and the directions away from `center_mm`.
double worst_normal_deg(const std::vector<SlabMesh>& meshes, const VolumeShape& shape,
                        glm::dvec3 center_mm) {
    double worst = 0;
    for (const SlabMesh& mesh : meshes)
        for (const Vertex& vertex : mesh.vertices) {
            const glm::dvec3 p(shape.voxel_to_patient * glm::dvec4(vertex.p_voxel, 1));
            const glm::dvec3 n(vertex.normal[0], vertex.normal[1], vertex.normal[2]);
            const double cosine = glm::dot(glm::normalize(p - center_mm), n) / 32767;
            worst = std::max(worst, std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / pi);
            CHECK(glm::length(n) == doctest::Approx(32767).epsilon(1e-4));
        }
    return worst;
}

}  // namespace

TEST_SUITE("gp/shapes") {
    TEST_CASE("a sphere has its area, volume and normals, on stretched, mirrored, tilted grids") {
        const Size size{60, 52, 30};
        const double radius_mm = 20;
        const glm::dvec3 center_mm(12, -30, 55);
        for (const glm::dmat3& steps : {anisotropic(), mirrored(), tilted()}) {
            const auto volume = place(size, grid(size, steps, center_mm), [&](glm::dvec3 p) {
                return 100 - glm::distance(p, center_mm);
            });
            const auto meshes = extract_all(volume, 100 - radius_mm);
            const Certificate certificate = certify(meshes, volume.shape);
            CHECK_MESSAGE(certificate.closed(), certificate);
            CHECK(certificate.euler() == 2);
            CHECK(certificate.components == 1);
            CHECK(certificate.area_mm2 ==
                  doctest::Approx(4 * pi * radius_mm * radius_mm).epsilon(0.01));
            CHECK(certificate.volume_mm3 ==
                  doctest::Approx(4 * pi / 3 * std::pow(radius_mm, 3)).epsilon(0.01));
            CHECK(worst_normal_deg(meshes, volume.shape, center_mm) < 1);
        }
    }

    TEST_CASE(
        "triangles are counter-clockwise seen from outside, in the patient, mirrored or not") {
        const Size size{24, 24, 14};
        for (const glm::dmat3& steps : {anisotropic(), mirrored(), tilted()}) {
            const auto volume = place(size, grid(size, steps, {0, 0, 0}),
                                      [&](glm::dvec3 p) { return 100 - glm::length(p); });
            std::size_t inward = 0;
            for (const SlabMesh& mesh : extract_all(volume, 92.001))
                for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
                    glm::dvec3 p[3];
                    for (std::size_t j = 0; j < 3; ++j)
                        p[j] =
                            glm::dvec3(volume.shape.voxel_to_patient *
                                       glm::dvec4(mesh.vertices[mesh.indices[i + j]].p_voxel, 1));
                    const glm::dvec3 n = glm::cross(p[1] - p[0], p[2] - p[0]);
                    inward += glm::dot(n, p[0] + p[1] + p[2]) < 0 ? 1 : 0;
                }
            CHECK(inward == 0);
        }
    }

    TEST_CASE("a sphere on unevenly spaced slices has its area, volume and normals") {
        const Size size{60, 52, 40};
        const double radius_mm = 20;
        for (const glm::dmat3& steps : {anisotropic(), mirrored(), tilted()})
            for (const int slabs_per_set : {1, 3}) {
                // Spacing swings between 0.6 and 1.4 steps, and jumps by 3 at a gap.
                std::vector<double> places;
                for (double z = 0; static_cast<int>(places.size()) < size.nz;) {
                    places.push_back(z);
                    z += places.size() == 17 ? 3 : 1 + 0.4 * std::sin(double(places.size()));
                }
                glm::dmat4 to_patient(steps);
                to_patient[3] = glm::dvec4(-steps * glm::dvec3(30, 26, places.back() / 2), 1);
                Volume volume = make_volume(size, Scalar::float32, [&](int x, int y, int z) {
                    const double at = places[static_cast<std::size_t>(z)];
                    return 100 - glm::length(glm::dvec3(to_patient * glm::dvec4(x, y, at, 1)));
                });
                volume.shape.voxel_to_patient = to_patient;
                volume.shape.slice_places = places;
                volume.shape.slabs_per_set = slabs_per_set;
                const auto meshes = extract_all(volume, 100 - radius_mm, CaseRule::watertight, 2);
                const Certificate certificate = certify(meshes, volume.shape);
                CHECK_MESSAGE(certificate.closed(), certificate);
                CHECK(certificate.area_mm2 ==
                      doctest::Approx(4 * pi * radius_mm * radius_mm).epsilon(0.01));
                CHECK(certificate.volume_mm3 ==
                      doctest::Approx(4 * pi / 3 * std::pow(radius_mm, 3)).epsilon(0.01));
                CHECK(worst_normal_deg(meshes, volume.shape, {0, 0, 0}) < 8);
            }
    }

    TEST_CASE("half a ball at the last x face has its volume on unevenly spaced slices") {
        const Size size{30, 40, 30};
        const double radius = 12;
        std::vector<double> places;
        for (int z = 0; z < size.nz; ++z) places.push_back(z + 0.45 * std::sin(1.7 * z));
        const glm::dvec3 center(size.nx - 1, 19.5, 15);
        Volume volume = make_volume(size, Scalar::float32, [&](int x, int y, int z) {
            return 100 - glm::distance({x, y, places[static_cast<std::size_t>(z)]}, center);
        });
        volume.shape.slice_places = places;
        double enclosed = 0;
        for (const SlabMesh& mesh : extract_all(volume, 100 - radius))
            enclosed += mesh.counts.volume_mm3;
        CHECK(enclosed == doctest::Approx(2 * pi / 3 * std::pow(radius, 3)).epsilon(0.01));
    }

    TEST_CASE("slices said to lie where they would lie anyway change no bit") {
        const Size size{20, 18, 16};
        Volume volume = make_volume(size, Scalar::int16, [](int x, int y, int z) {
            return 100 + 90 * std::sin(0.7 * x) * std::cos(0.5 * y) * std::sin(0.6 * z);
        });
        const auto plain = extract_all(volume, 120);
        for (int z = 0; z < size.nz; ++z) volume.shape.slice_places.push_back(z);
        const auto placed = extract_all(volume, 120);
        for (std::size_t s = 0; s < plain.size(); ++s) {
            REQUIRE(plain[s].vertices.size() == placed[s].vertices.size());
            CHECK(std::memcmp(plain[s].vertices.data(), placed[s].vertices.data(),
                              plain[s].vertices.size() * sizeof(Vertex)) == 0);
            CHECK(plain[s].counts.area_mm2 == placed[s].counts.area_mm2);
            CHECK(plain[s].counts.volume_mm3 == placed[s].counts.volume_mm3);
        }
    }

    TEST_CASE("a torus has one hole, its area and its volume") {
        const Size size{64, 64, 24};
        const double ring_mm = 20, tube_mm = 7;
        const auto volume = place(size, grid(size, glm::dmat3(1.0), {0, 0, 0}), [&](glm::dvec3 p) {
            return 100 - std::hypot(std::hypot(p.x, p.y) - ring_mm, p.z);
        });
        const Certificate certificate = certify(extract_all(volume, 100 - tube_mm), volume.shape);
        CHECK_MESSAGE(certificate.closed(), certificate);
        CHECK(certificate.euler() == 0);
        CHECK(certificate.area_mm2 ==
              doctest::Approx(4 * pi * pi * ring_mm * tube_mm).epsilon(0.01));
        CHECK(certificate.volume_mm3 ==
              doctest::Approx(2 * pi * pi * ring_mm * tube_mm * tube_mm).epsilon(0.01));
    }

    TEST_CASE("a ball cut by the volume's faces has the volume of what lies within") {
        // Centerd on a face, an edge or a corner of the volume: a half, a quarter, an eighth.
        const Size size{30, 26, 22};
        const glm::dvec3 last(size.nx - 1, size.ny - 1, size.nz - 1);
        const double radius = 9, whole = 4 * pi / 3 * radius * radius * radius;
        for (const glm::dvec3 place_of_center : {glm::dvec3(0, 0.5, 0.5),
                                                 {1, 0.5, 0.5},
                                                 {0.5, 0, 0.5},
                                                 {0.5, 1, 0.5},
                                                 {0.5, 0.5, 0},
                                                 {0.5, 0.5, 1},
                                                 {1, 1, 0.5},
                                                 {0, 1, 0.5},
                                                 {1, 1, 1},
                                                 {0, 0, 0},
                                                 {1, 0, 1}}) {
            double part = 1;
            for (int axis = 0; axis < 3; ++axis) part *= place_of_center[axis] == 0.5 ? 1 : 0.5;
            for (const glm::dmat3& steps : {glm::dmat3(1.0), mirrored()}) {
                const glm::dvec3 center = place_of_center * last;
                const auto volume = make_volume(size, Scalar::float32, [&](int x, int y, int z) {
                    return 100 - glm::distance(glm::dvec3(x, y, z), center);
                });
                Volume placed = volume;
                placed.shape.voxel_to_patient = glm::dmat4(steps);
                double enclosed = 0;
                for (const SlabMesh& mesh : extract_all(placed, 100 - radius))
                    enclosed += mesh.counts.volume_mm3;
                INFO(place_of_center.x, " ", place_of_center.y, " ", place_of_center.z);
                CHECK(enclosed == doctest::Approx(part * whole * std::abs(glm::determinant(steps)))
                                      .epsilon(0.02));
            }
        }
    }

    TEST_CASE("the last x face is cut where the surface is, also beside an infinite voxel") {
        // A prism along x: one infinite corner of the square of y and z. The surface cuts the edge
        // from the lower, finite voxel at that voxel, and the one from the infinite voxel halfway.
        const double infinity = std::numeric_limits<double>::infinity();
        const auto prism = make_volume({4, 2, 2}, Scalar::float32, [&](int, int y, int z) {
            return y == 1 && z == 0 ? infinity : 0;
        });
        const Certificate certificate = certify(extract_all(prism, 5.5), prism.shape);
        CHECK_MESSAGE(certificate.good(), certificate);
        CHECK(certificate.area_mm2 == doctest::Approx(3 * std::hypot(1, 0.5)));
        CHECK(certificate.volume_mm3 == doctest::Approx(3 * 0.25));
        // Two such corners across: each has one side cut at a finite voxel, one halfway.
        const auto pair = make_volume({4, 2, 2}, Scalar::float32,
                                      [&](int, int y, int z) { return y != z ? infinity : 0; });
        const Certificate both = certify(extract_all(pair, 5.5), pair.shape);
        CHECK(both.volume_mm3 == doctest::Approx(3 * (0.25 + 0.25)));
    }

    TEST_CASE("an ambiguous last x face is closed as its case table decides") {
        // A prism along x: inside corners across, whose saddle is inside. Edges are cut at 5/6.
        const auto prism = make_volume({4, 2, 2}, Scalar::int16,
                                       [](int, int y, int z) { return y == z ? 10 : 4; });
        const auto per_length = [&](CaseRule rule) {
            double enclosed = 0;
            for (const SlabMesh& mesh : extract_all(prism, 5, rule)) {
                enclosed += mesh.counts.volume_mm3;
            }
            return enclosed / 3;
        };
        CHECK(per_length(CaseRule::watertight) == doctest::Approx(25.0 / 36));
        CHECK(per_length(CaseRule::asymptotic) == doctest::Approx(1 - 1.0 / 36));
    }

    TEST_CASE("where everything is inside, the volume is the box") {
        const auto volume = make_volume({5, 4, 3}, Scalar::int16, [](int, int, int) { return 9; });
        double enclosed = 0;
        for (const SlabMesh& mesh : extract_all(volume, 1)) enclosed += mesh.counts.volume_mm3;
        CHECK(enclosed == doctest::Approx(4 * 3 * 2));
    }

    TEST_CASE("two spheres are two components") {
        const Size size{48, 24, 24};
        const auto volume = place(size, grid(size, glm::dmat3(1.0), {0, 0, 0}), [](glm::dvec3 p) {
            return 100 - std::min(glm::distance(p, glm::dvec3(-12, 0, 0)),
                                  glm::distance(p, glm::dvec3(11, 1, 0)));
        });
        const Certificate certificate = certify(extract_all(volume, 91), volume.shape);
        CHECK(certificate.closed());
        CHECK(certificate.components == 2);
        CHECK(certificate.euler() == 4);
    }
}
