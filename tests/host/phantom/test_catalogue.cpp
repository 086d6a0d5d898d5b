#include <doctest/doctest.h>

#include <iomanip>
#include <set>
#include <sstream>

#include "host/base/digest.hpp"
#include "tests/golden.hpp"
#include "tests/host/phantom/phantom_probe.hpp"

using namespace pxpl5;
using namespace pxpl5::test;

namespace {

std::string message_for(std::string_view name) {
    try {
        host::make_phantom(name);
    } catch (const std::invalid_argument& error) {
        return error.what();
    }
    return "";
}

bool holds(const std::string& text, std::string_view part) {
    return text.find(part) != std::string::npos;
}

}  // namespace

TEST_SUITE("host/phantom/catalogue") {
    TEST_CASE("names are unique and every volume is what its info says") {
        std::set<std::string> names;
        for (const host::PhantomInfo& info : host::phantoms()) {
            CAPTURE(info.name);
            CHECK(names.insert(info.name).second);
            CHECK(host::is_phantom(info.name));
            const host::Volume v = host::make_phantom(info.name);
            CHECK(v.name == info.name);
            CHECK(v.nx == info.dims[0]);
            CHECK(v.ny == info.dims[1]);
            CHECK(v.nz == info.dims[2]);
            CHECK(v.type == info.type);
            const auto count = static_cast<std::size_t>(v.nx) * static_cast<std::size_t>(v.ny) *
                               static_cast<std::size_t>(v.nz);
            CHECK(v.values.size() == count * size_bytes(v.type));
            for (int i = 0; i < 3; ++i)
                CHECK(v.voxel_to_patient[i][i] == info.spacing_mm[static_cast<std::size_t>(i)]);
        }
        CHECK(names.size() == 8);
    }

    TEST_CASE("minimum and maximum are those of the voxels, and isovalues lie between") {
        for (const host::PhantomInfo& info : host::phantoms()) {
            CAPTURE(info.name);
            const Probe probe(info.name);
            const auto [low, high] = std::minmax_element(probe.voxels.begin(), probe.voxels.end());
            CHECK(probe.volume.minimum == *low);
            CHECK(probe.volume.maximum == *high);
            CHECK_FALSE(info.surfaces.empty());
            for (const host::PhantomSurface& surface : info.surfaces) {
                CHECK(surface.isovalue > *low);
                CHECK(surface.isovalue < *high);
                // No voxel can lie on such an isovalue, so no triangle is flat by chance.
                CHECK(surface.isovalue - std::floor(surface.isovalue) == 0.5);
            }
        }
    }

    TEST_CASE("the paper's volumes have the paper's sizes") {
        CHECK(info_of("phantom:pelvis").dims == std::array<int, 3>{128, 128, 56});
        CHECK(info_of("phantom:fetus").dims == std::array<int, 3>{128, 64, 96});
        CHECK(info_of("phantom:head").dims == std::array<int, 3>{96, 96, 109});
    }

    TEST_CASE("an unknown name is answered with the nearest and with all") {
        const std::string message = message_for("phantom:pelvic");
        CHECK(holds(message, "no phantom \"phantom:pelvic\""));
        CHECK(holds(message, "did you mean phantom:pelvis?"));
        for (const host::PhantomInfo& info : host::phantoms()) CHECK(holds(message, info.name));
        CHECK(holds(message_for("phantom:letter"), "did you mean phantom:letters?"));
        CHECK(holds(message_for("phantom:"), "Known:"));
    }

    TEST_CASE("each volume of a time series says which one it is") {
        CHECK(info_of("phantom:heart").frames == 30);
        CHECK(info_of("phantom:heart").frame_ms == 30);
        for (const std::string name : {"phantom:heart", "phantom:waving-fetus"}) {
            const host::PhantomInfo info = info_of(name);
            std::set<std::vector<std::byte>> seen;
            for (const int frame : {1, 4, 12}) {
                const host::Volume volume = host::make_phantom(name, frame);
                CHECK(volume.frame == frame);
                CHECK(volume.frames == info.frames);
                CHECK(volume.frame_ms == info.frame_ms);
                CHECK(seen.insert(volume.values).second);
            }
            CHECK_THROWS_AS(host::make_phantom(name, 0), std::invalid_argument);
            CHECK_THROWS_AS(host::make_phantom(name, info.frames + 1), std::invalid_argument);
        }
        CHECK_THROWS_AS(host::make_phantom("phantom:torus", 2), std::invalid_argument);
    }

    TEST_CASE("the fetus that moves begins at rest") {
        CHECK(host::make_phantom("phantom:waving-fetus", 1).values ==
              host::make_phantom("phantom:fetus").values);
    }

    TEST_CASE("a name is a phantom's by its prefix") {
        CHECK(host::is_phantom("phantom:nothing"));
        CHECK_FALSE(host::is_phantom("phantom.nrrd"));
        CHECK_FALSE(host::is_phantom("a/phantom:pelvis"));
    }

    TEST_CASE("voxels are the same to the bit as everywhere") {
        std::ostringstream got;
        for (const host::PhantomInfo& info : host::phantoms()) {
            for (int frame = 1; frame <= info.frames; frame += 12) {
                host::Digest digest;
                digest.add(host::make_phantom(info.name, frame).values);
                got << info.name << (frame > 1 ? " frame=" + std::to_string(frame) : "") << ' '
                    << std::hex << std::setw(16) << std::setfill('0') << digest.value() << '\n';
            }
        }
        check_golden("phantom.txt", got.str(), "ctest --preset release -R host_phantom");
    }
}
