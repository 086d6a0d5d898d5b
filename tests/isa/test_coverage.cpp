// Compares the coverage of the conformance suite with frames of the phantoms.
#include <doctest/doctest.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

#include "host/inspect/record/region_walk.hpp"
#include "renderer_firmware/fast/fast.hpp"
#include "tests/host/inspect/recorded_machine.hpp"
#include "tests/isa/coverage.hpp"

using namespace pxpl5;

namespace {

/// Walks through the regions of the newest frame.
void note_frame(const host::inspect::RecordedRun& run, test::Coverage& coverage) {
    const host::inspect::RecordedFrame frame = run.frame(run.frames().back());
    REQUIRE(frame.missing.empty());
    for (const auto& [number, region] : frame.regions) {
        renderer::fast::Fast executor;
        host::inspect::RegionWalk walk(region.plan, executor);
        while (!walk.done()) {
            coverage.note(walk.next(), test::enables_of(executor));
            walk.step();
        }
    }
}

test::Coverage coverage_of_phantoms() {
    test::Coverage coverage;
    for (const char* phantom : {"phantom:pelvis", "phantom:letters", "phantom:sphere"}) {
        host::Topology topology;
        topology.gp.count = 1;
        topology.renderer.count = 1;
        topology.frame_buffer.count = 1;
        test::RecordedMachine recorded(topology);
        recorded.session.scene.size = {192, 128};
        recorded.session.scene.lights = {{-28, 32, 0.7}, {50, -10, 0.3}, {0, 80, 0.2}};
        recorded.session.volumes.load(phantom);
        const host::Volume& volume = recorded.session.volumes.volume();
        recorded.session.surfaces.set("surface", (volume.minimum + volume.maximum) / 2,
                                      CaseRule::watertight, {200, 180, 160});
        recorded.session.frames.draw();
        note_frame(recorded.run(), coverage);
    }
    return coverage;
}

constexpr const char* report = PXPL5_SOURCE_DIR "/tests/isa/conformance/COVERAGE.md";

}  // namespace

TEST_CASE("the report of coverage is what suite and phantoms say") {
    const std::string text =
        test::coverage_markdown(test::coverage_of_suite(), coverage_of_phantoms());
    if (std::getenv("PXPL5_UPDATE_GOLDEN") != nullptr) {
        std::ofstream(report, std::ios::binary) << text;
    }
    std::ostringstream written;
    written << std::ifstream(report, std::ios::binary).rdbuf();
    CHECK_MESSAGE(written.str() == text,
                  "tests/isa/conformance/COVERAGE.md is stale: run  PXPL5_UPDATE_GOLDEN=1 ctest "
                  "--preset release -R isa_coverage");
}
