#include <doctest/doctest.h>

#include "tests/gp_firmware/surface/mesh_check.hpp"
#include "tests/host/phantom/phantom_probe.hpp"

using namespace pxpl5;
using namespace pxpl5::test;

TEST_SUITE("host/phantom/surfaces") {
    TEST_CASE("the paper's surfaces have the paper's triangle counts within 5 %") {
        // Source: Yoo & Chen, figures 3 to 7.
        const std::pair<const char*, int> paper[] = {{"phantom:pelvis skin", 41708},
                                                     {"phantom:pelvis muscle", 110450},
                                                     {"phantom:pelvis bone", 49552},
                                                     {"phantom:fetus face", 70874},
                                                     {"phantom:head skin", 269720}};
        std::size_t found = 0;
        for (const host::PhantomInfo& info : host::phantoms()) {
            const Volume volume = for_gps(host::make_phantom(info.name));
            for (const host::PhantomSurface& surface : info.surfaces)
                for (const auto& [name, triangles] : paper) {
                    if (info.name + " " + surface.name != name) continue;
                    ++found;
                    CAPTURE(std::string(name));
                    CHECK(surface.paper_triangles == triangles);
                    std::size_t count = 0;
                    for (const gp::SlabMesh& mesh : extract_all(volume, surface.isovalue))
                        count += mesh.counts.triangles;
                    MESSAGE(std::string(name)
                            << ": " << count << " triangles, the paper has " << triangles);
                    CHECK(static_cast<double>(count) > 0.95 * triangles);
                    CHECK(static_cast<double>(count) < 1.05 * triangles);
                }
        }
        CHECK(found == std::size(paper));
    }

    TEST_CASE("every surface is manifold, oriented, and open at the volume's border alone") {
        for (const host::PhantomInfo& info : host::phantoms()) {
            const Volume volume = for_gps(host::make_phantom(info.name));
            for (const host::PhantomSurface& surface : info.surfaces) {
                CAPTURE(info.name);
                CAPTURE(surface.name);
                const Certificate c = certify(extract_all(volume, surface.isovalue), volume.shape);
                CHECK_MESSAGE(c.good(), c);
            }
        }
    }
}
