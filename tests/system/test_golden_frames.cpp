// Tests meshes and frames of the built-in volumes to the bit, on the smallest machine.
#include <doctest/doctest.h>
#include <fmt/core.h>

#include "host/commands/text/picture_text.hpp"
#include "host/phantom/phantom.hpp"
#include "host/session/session.hpp"
#include "tests/golden.hpp"
#include "tests/system/simulated_machine.hpp"

using namespace pxpl5;
using namespace pxpl5::host;

namespace {

Topology least_machine() {
    Topology topology;
    topology.gp.count = topology.renderer.count = topology.frame_buffer.count = 1;
    return topology;
}

/// One line for each surface of the phantom.
std::string lines_of(Session& session, const PhantomInfo& phantom) {
    std::string lines;
    session.volumes.load(phantom.name);
    for (const PhantomSurface& surface : phantom.surfaces) {
        const SurfaceReport report = session.surfaces.set(
            surface.name, surface.isovalue, CaseRule::watertight,
            {surface.color_rgb[0], surface.color_rgb[1], surface.color_rgb[2]});
        lines += fmt::format("{} {}: {} triangles, mesh {:016x}, frame {:016x}\n", phantom.name,
                             surface.name, report.triangles, session.meshes.digest(surface.name),
                             picture_digest(session.frames.draw()));
        session.surfaces.remove(surface.name);
    }
    return lines;
}

}  // namespace

TEST_CASE("meshes and frames of the built-in volumes and archives are what they were") {
    test::SimulatedMachine machine(least_machine());
    Session session(machine);
    session.scene.size = {320, 240};
    session.scene.camera.angles = {30, 20};
    session.scene.lights = {{-28, 32, 0.7}, {50, -10, 0.3}};
    std::string lines;
    for (const PhantomInfo& phantom : phantoms()) {
        lines += lines_of(session, phantom);
    }
    session.volumes.load("phantom:pelvis");
    session.surfaces.set("bone", 250.5, CaseRule::watertight, {236, 226, 200});
    for (const int samples : {4, 16}) {
        lines += fmt::format("phantom:pelvis bone, {} samples: frame {:016x}\n", samples,
                             picture_digest(*session.frames.draw_samples(samples)));
    }
    for (const char* name : {"molecule", "room", "tree"}) {
        session.volumes.load(std::string(PXPL5_SOURCE_DIR) + "/host/phigs/archives/" + name +
                             ".phigs");
        const ArchiveFacts& scene = *session.volumes.archive();
        lines += fmt::format("{}.phigs: {} triangles, {} spheres, {} lines, frame {:016x}\n", name,
                             scene.triangles, scene.spheres, scene.lines,
                             picture_digest(session.frames.draw()));
    }
    test::check_golden("frames.txt", lines, "ctest --preset release -R golden_frames");
}
