// Tests the first surfaces of an opened volume.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <span>

#include "host/commands/text/first_surfaces.hpp"
#include "host/commands/text/tissues.hpp"

using namespace pxpl5;
using namespace pxpl5::host;

namespace {

/// A volume whose voxels have one of two values, half of them each.
Volume halves(const char* modality, std::int16_t low, std::int16_t high) {
    Volume volume;
    volume.name = "scan";
    volume.modality = modality;
    volume.nx = volume.ny = volume.nz = 4;
    volume.type = Scalar::int16;
    volume.minimum = low;
    volume.maximum = high;
    std::array<std::int16_t, 64> values{};
    std::fill_n(values.begin(), 32, low);
    std::fill_n(values.begin() + 32, 32, high);
    const auto bytes = std::as_bytes(std::span(values));
    volume.values.assign(bytes.begin(), bytes.end());
    return volume;
}

/// A single surface that parts the two values.
void check_parted(const Volume& volume) {
    const auto surfaces = first_surfaces(volume);
    REQUIRE(surfaces.size() == 1);
    CHECK(surfaces[0].name == "surface");
    CHECK_FALSE(surfaces[0].seen_through);
    REQUIRE(surfaces[0].isovalue.has_value());
    CHECK(*surfaces[0].isovalue > volume.minimum);
    CHECK(*surfaces[0].isovalue < volume.maximum);
}

}  // namespace

TEST_CASE("a CT first shows bone, and skin that is seen through") {
    const std::vector<FirstSurface> expected = {{"bone", {}, false}, {"skin", {}, true}};
    CHECK(first_surfaces(halves("CT", -1000, 1200)) == expected);
}

TEST_CASE("a scan without both tissues first shows what parts its values in two") {
    check_parted(halves("CT", 0, 4095));      // Not in Hounsfield units.
    check_parted(halves("CT", -1000, 100));   // No bone.
    check_parted(halves("MR", -1000, 1200));  // No CT.
    check_parted(halves("", -1000, 1200));
}

TEST_CASE("a built-in volume first shows what is suggested for it") {
    Volume volume = halves("", 0, 1);
    volume.name = "phantom:pelvis";
    const std::vector<FirstSurface> pelvis = {{"bone", {}, false}, {"skin", {}, true}};
    CHECK(first_surfaces(volume) == pelvis);
    volume.name = "phantom:sphere";
    const std::vector<FirstSurface> sphere = {{"surface", {}, false}};
    CHECK(first_surfaces(volume) == sphere);
}

TEST_CASE("tissues of CT are refused for scans of another modality, with advice") {
    for (const char* modality : {"MR", "PT", "US"}) {
        const std::string text = refusal_of_tissue("bone", modality);
        CAPTURE(text);
        CHECK(text.find("preset=bone is an isovalue in Hounsfield units") == 0);
        CHECK(text.find(std::string("this volume is ") + modality) != std::string::npos);
        CHECK(text.find("give iso=V") != std::string::npos);
    }
    CHECK(refusal_of_tissue("bone", "CT").empty());
    CHECK(refusal_of_tissue("bone", "").empty());
}
