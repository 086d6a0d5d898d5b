#include <doctest/doctest.h>

#include "tests/gp_firmware/surface/mesh_check.hpp"
#include "tests/host/phantom/phantom_probe.hpp"

using namespace pxpl5;
using namespace pxpl5::test;

namespace {

constexpr double pi = 3.14159265358979323846;

/// Where the analytic shapes are centered.
constexpr glm::dvec3 center_mm(0.3, -0.7, 0.45);

double length_mm(const host::PhantomInfo& info, std::string_view name) {
    for (const host::PhantomLength& length : info.lengths)
        if (length.name == name) return length.length_mm;
    throw std::out_of_range(std::string(name));
}

/// Voxels whose density is not the depth in 0.01 mm, within one unit, or on the wrong side.
template <class Depth>
std::size_t wrong_voxels(const Probe& probe, double zero, const Depth& depth_mm) {
    std::size_t wrong = 0;
    probe.each([&](double value, glm::dvec3 p) {
        const double depth = depth_mm(p - center_mm);
        const bool off = std::abs(value - (zero + 100 * depth)) > 1 + 1e-3;
        const bool wrong_side = std::abs(depth) > 1e-6 && (value > zero + 0.5) != (depth > 0);
        wrong += off || wrong_side ? 1 : 0;
    });
    return wrong;
}

Certificate certificate_of(const Probe& probe, double isovalue) {
    const Volume volume = for_gps(probe.volume);
    return certify(extract_all(volume, isovalue), volume.shape);
}

}  // namespace

TEST_SUITE("host/phantom/analytic") {
    TEST_CASE("the sphere's density is the depth below its surface, everywhere") {
        const Probe probe("phantom:sphere");
        const double radius = length_mm(info_of("phantom:sphere"), "radius");
        CHECK(wrong_voxels(probe, 0, [&](glm::dvec3 p) { return radius - glm::length(p); }) == 0);
    }

    TEST_CASE("the sphere's surface has its area, volume and genus") {
        const host::PhantomInfo info = info_of("phantom:sphere");
        const double r = length_mm(info, "radius");
        const Certificate c = certificate_of(Probe(info.name), info.surfaces.at(0).isovalue);
        CHECK_MESSAGE(c.closed(), c);
        CHECK(c.euler() == 2);
        CHECK(c.area_mm2 == doctest::Approx(4 * pi * r * r).epsilon(0.005));
        CHECK(c.volume_mm3 == doctest::Approx(4 * pi / 3 * r * r * r).epsilon(0.005));
    }

    TEST_CASE("the torus's density is the depth below its surface, everywhere") {
        const host::PhantomInfo info = info_of("phantom:torus");
        const double ring = length_mm(info, "ring radius"), tube = length_mm(info, "tube radius");
        const auto depth = [&](glm::dvec3 p) {
            return tube - std::hypot(std::hypot(p.x, p.y) - ring, p.z);
        };
        CHECK(wrong_voxels(Probe(info.name), 30000, depth) == 0);
    }

    TEST_CASE("the torus's surface has its area, volume and one hole") {
        const host::PhantomInfo info = info_of("phantom:torus");
        const double ring = length_mm(info, "ring radius"), tube = length_mm(info, "tube radius");
        const Certificate c = certificate_of(Probe(info.name), info.surfaces.at(0).isovalue);
        CHECK_MESSAGE(c.closed(), c);
        CHECK(c.euler() == 0);
        CHECK(c.area_mm2 == doctest::Approx(4 * pi * pi * ring * tube).epsilon(0.01));
        CHECK(c.volume_mm3 == doctest::Approx(2 * pi * pi * ring * tube * tube).epsilon(0.01));
    }
}
