#include <doctest/doctest.h>

#include "tests/gp_firmware/surface/mesh_check.hpp"
#include "tests/host/phantom/phantom_probe.hpp"

using namespace pxpl5;
using namespace pxpl5::test;

namespace {

constexpr double bone_hu = 250;

/// Whether both mirror images of a place pass.
template <class Pass>
bool both_sides(const Probe& probe, glm::dvec3 p, const Pass& pass) {
    return pass(probe.near_mm(p.x, p.y, p.z)) && pass(probe.near_mm(-p.x, p.y, p.z));
}

bool is_bone(double hu) {
    return hu > bone_hu;
}
bool is_soft(double hu) {
    return hu > -200 && hu < bone_hu;
}

/// The voxel at or above `isovalue` that lies furthest along `direction`.
glm::dvec3 furthest_mm(const Probe& probe, double isovalue, glm::dvec3 direction) {
    glm::dvec3 best(0);
    double reach = -1e9;
    probe.each([&](double value, glm::dvec3 p) {
        if (value >= isovalue && glm::dot(p, direction) > reach) {
            reach = glm::dot(p, direction);
            best = p;
        }
    });
    return best;
}

/// Share of voxels that pass, of those in a ball.
template <class Pass>
double share(const Probe& probe, glm::dvec3 center, double radius_mm, const Pass& pass) {
    double all = 0, passed = 0;
    probe.each([&](double value, glm::dvec3 p) {
        if (glm::distance(p, center) > radius_mm) return;
        ++all;
        passed += pass(value) ? 1 : 0;
    });
    return passed / all;
}

}  // namespace

TEST_SUITE("host/phantom/anatomy") {
    TEST_CASE("the pelvis has bones where a pelvis has them, on both sides") {
        const Probe probe("phantom:pelvis");
        CHECK(both_sides(probe, {86, 0, 0}, is_bone));      // Femur heads.
        CHECK(both_sides(probe, {120, -48, 80}, is_bone));  // Anterior superior spines.
        CHECK(both_sides(probe, {134, 12, 127}, is_bone));  // Iliac crests.
        CHECK(both_sides(probe, {60, 26, -68}, is_bone));   // Ischial tuberosities.
        CHECK(both_sides(probe, {132, 12, -25}, is_bone));  // Greater trochanters.
        CHECK(probe.near_mm(0, 38, 84) > bone_hu);          // First sacral vertebra.
        CHECK(probe.near_mm(0, 62, -32) > bone_hu);         // Coccyx.
    }

    TEST_CASE("the pelvis has holes where a pelvis has them") {
        const Probe probe("phantom:pelvis");
        CHECK(probe.near_mm(0, -42, -26) < bone_hu);        // Symphysis: cartilage.
        CHECK(both_sides(probe, {48, -14, -30}, is_soft));  // Obturator foramina.
        CHECK(both_sides(probe, {60, 62, 10}, is_soft));    // Greater sciatic notches.
        CHECK(both_sides(probe, {26, 46, 67}, is_soft));    // First foramina of the sacrum.
        CHECK(probe.near_mm(0, 10, 0) < bone_hu);           // The pelvis's inside.
        CHECK(both_sides(probe, {120, 3, -80}, is_soft));   // Marrow of the femurs.
    }

    TEST_CASE("the femur head is a ball in its socket, apart from the hip bone") {
        const Probe probe("phantom:pelvis");
        const double radius = info_of("phantom:pelvis").lengths.at(0).length_mm;
        CHECK(share(probe, {86, 0, 0}, radius - 3, is_bone) > 0.99);
        // Inwards and upwards: head, cartilage, hip bone.
        const glm::dvec3 inwards = glm::normalize(glm::dvec3(-0.5, 0.2, 0.84));
        double least = 1e9;
        for (double d = radius - 2; d < radius + 8; d += 0.5) {
            const glm::dvec3 p = glm::dvec3(86, 0, 0) + d * inwards;
            least = std::min(least, probe.near_mm(p.x, p.y, p.z));
        }
        CHECK(least < bone_hu);
        const glm::dvec3 roof = glm::dvec3(86, 0, 0) + (radius + 9) * inwards;
        CHECK(probe.near_mm(roof.x, roof.y, roof.z) > bone_hu);
    }

    TEST_CASE("the pelvis spans air to dense bone, and bowel gas is on the left alone") {
        const Probe probe("phantom:pelvis");
        CHECK(probe.volume.minimum < -950);
        CHECK(probe.volume.maximum > 900);
        CHECK(probe.near_mm(70, -40, 98) < -700);
        CHECK(probe.near_mm(-70, -40, 98) > -200);
        CHECK(is_soft(probe.near_mm(70, 84, 4)));  // Gluteus.
        CHECK(probe.near_mm(70, 84, 4) > 0);
        CHECK(probe.near_mm(0, -150, 20) < -900);  // Outside.
    }

    TEST_CASE("density is linear across the pelvis's skin, so that its shading has no steps") {
        const Probe probe("phantom:pelvis");
        const double iso = info_of("phantom:pelvis").surfaces.at(1).isovalue;
        const host::Volume& v = probe.volume;
        std::size_t steep = 0, bent = 0;
        const auto look = [&](double before, double here, double after) {
            // Only where the axis runs through the skin rather than along it.
            if (std::abs(here - iso) > 50 || std::abs(after - before) < 100) return;
            ++steep;
            // A straight line has none; a sphere of 30 mm, sampled every 4 mm, has 4 / (2 * 30).
            bent += std::abs(after + before - 2 * here) > 0.25 * std::abs(after - before) ? 1 : 0;
        };
        for (int z = 1; z + 1 < v.nz; ++z)
            for (int y = 1; y + 1 < v.ny; ++y)
                for (int x = 1; x + 1 < v.nx; ++x) {
                    const double here = probe.at(x, y, z);
                    look(probe.at(x - 1, y, z), here, probe.at(x + 1, y, z));
                    look(probe.at(x, y - 1, z), here, probe.at(x, y + 1, z));
                    look(probe.at(x, y, z - 1), here, probe.at(x, y, z + 1));
                }
        REQUIRE(steep > 1000);
        CHECK(bent < steep / 20);
        MESSAGE("bent at " << bent << " of " << steep << " places");
    }

    TEST_CASE("the fetus looks forwards, nose first, with its left hand at its cheek") {
        const Probe probe("phantom:fetus");
        const double iso = info_of("phantom:fetus").surfaces.at(0).isovalue;
        const glm::dvec3 nose = furthest_mm(probe, iso, {0, -1, 0});
        CHECK(std::abs(nose.x) < 3);
        CHECK(nose.z > -9);
        CHECK(nose.z < -1);
        CHECK(probe.near_mm(26.5, -6, -22) >= iso);  // Palm.
        CHECK(probe.near_mm(-26.5, -6, -22) < iso);
        CHECK(probe.near_mm(0, -24, 0) < iso);  // Fluid before the face.
    }

    TEST_CASE("nothing is heard outside of the probe's fan") {
        const Probe probe("phantom:fetus");
        const auto& v = probe.volume;
        for (const int x : {0, v.nx - 1})
            for (int z = 0; z < v.nz; ++z) CHECK(probe.at(x, 0, z) == 0);
        CHECK(probe.near_mm(0, -20, 0) > 0);
    }

    TEST_CASE("the head looks forwards: nose in front, ears at the sides, crown on top") {
        const Probe probe("phantom:head");
        const double iso = info_of("phantom:head").surfaces.at(0).isovalue;
        const glm::dvec3 nose = furthest_mm(probe, iso, {0, -1, 0});
        CHECK(std::abs(nose.x) < 4);
        CHECK(nose.z < -15);
        CHECK(nose.z > -35);
        for (const double side : {-1.0, 1.0}) {
            const glm::dvec3 ear = furthest_mm(probe, iso, {side, 0, 0});
            CHECK(std::abs(ear.x) > 80);
            CHECK(std::abs(ear.z) < 25);
            CHECK(ear.y > 0);
        }
        CHECK(furthest_mm(probe, iso, {0, 0, 1}).z > 98);
    }

    TEST_CASE("the head holds skin, dark skull, bright brain and dark ventricles") {
        const Probe probe("phantom:head");
        double brightest_skull = 1e9, brain = 0;
        // From the crown downwards beside the middle.
        for (double z = 106; z > 60; z -= 1) {
            const double value = probe.near_mm(30, 10, z);
            if (z > 84) brightest_skull = std::min(brightest_skull, value);
            brain = std::max(brain, value);
        }
        CHECK(brightest_skull < 50);
        CHECK(brain > 230);
        CHECK(both_sides(probe, {8.5, 0, 46.5}, [](double v) { return v < 150; }));
        CHECK(probe.near_mm(0, 12, 45) > 200);  // What joins the hemispheres.
        CHECK(probe.near_mm(0, 12, 74) < 120);  // The fissure between them.
    }

    TEST_CASE("the brain is folded: its surface is more than twice that of a smooth one") {
        const Probe probe("phantom:head");
        const Volume volume = for_gps(probe.volume);
        const host::PhantomSurface brain = info_of("phantom:head").surfaces.at(1);
        CHECK(brain.name == "brain");
        const Certificate c = certify(extract_all(volume, brain.isovalue), volume.shape);
        // Source: Thomsen's formula for the area of an ellipsoid, within 1.1 %, of half axes that
        // hold the whole cerebrum.
        const double a = 58, b = 74, h = 52, p = 1.6075;
        const double hull =
            4 * 3.14159265 *
            std::pow((std::pow(a * b, p) + std::pow(a * h, p) + std::pow(b * h, p)) / 3, 1 / p);
        CHECK(c.area_mm2 > 2 * hull);
    }

    TEST_CASE("a walk around the brain, below its surface, crosses furrow after furrow") {
        const Probe probe("phantom:head");
        constexpr int steps = 720;
        int crossings = 0;
        bool was_dark = false;
        for (int i = 0; i <= steps; ++i) {
            const double angle = 2 * 3.14159265 * i / steps;
            const double x = 43 * std::sin(angle), y = 10 - 57 * std::cos(angle);
            const bool is_dark = probe.near_mm(x, y, 65) < 200.5;  // Not brain.
            crossings += is_dark && !was_dark ? 1 : 0;
            was_dark = is_dark;
        }
        // Furrows are 12.5 mm apart, so a path of 316 mm straight across all would meet 25.
        CHECK(crossings >= 25 / 2);
        CHECK(crossings <= 25 * 3 / 2);
    }

    TEST_CASE("no two hemispheres have the same folds") {
        const Probe probe("phantom:head");
        std::size_t brain = 0, differing = 0;
        for (int z = 0; z < probe.volume.nz; ++z)
            for (int y = 0; y < probe.volume.ny; ++y)
                for (int x = 0; x < probe.volume.nx / 2; ++x) {
                    const double right = probe.at(x, y, z);
                    const double left = probe.at(probe.volume.nx - 1 - x, y, z);
                    brain += right >= 200.5 || left >= 200.5 ? 1 : 0;
                    differing += (right >= 200.5) != (left >= 200.5) ? 1 : 0;
                }
        CHECK(differing > brain / 10);
    }
}
