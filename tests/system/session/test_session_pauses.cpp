// Long work of the host alone, which a viewer cancels.
#include <doctest/doctest.h>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "host/commands/commands.hpp"
#include "host/session/session.hpp"
#include "tests/system/session/canceling.hpp"
#include "tests/system/simulated_machine.hpp"

using namespace pxpl5;
using namespace pxpl5::host;

TEST_CASE("work of the host alone is canceled in its pauses and changes nothing") {
    Topology topology;
    topology.gp.count = 2;
    topology.renderer.count = 1;
    topology.frame_buffer.count = 1;
    topology.gp_memory_mib = 512;
    test::SimulatedMachine machine(topology);
    Session session(machine);
    const test::Canceling viewer(machine);
    session.volumes.load("phantom:head");
    session.surfaces.set("s", 0.5, CaseRule::watertight, {160, 160, 160});
    const ComponentFilter largest{.kind = ComponentFilter::Kind::largest};
    REQUIRE(session.surfaces.set_components("s", largest).parts.components.size() > 1);
    const auto picture = [&] {
        const Picture drawn = session.frames.draw();
        return std::vector<std::uint32_t>(drawn.rgba.begin(), drawn.rgba.end());
    };
    const std::vector<std::uint32_t> before = picture();
    int pauses = 0;
    machine.on_work = [&](const std::string& work) {
        if (work == "work on the mesh of s") {
            ++pauses;
            viewer.press();
        }
    };
    MeshExport smoothed;
    smoothed.smoothing = 5;
    const std::vector<std::function<void()>> works = {
        [&] { session.meshes.components(session.meshes.surface("s")); },
        [&] { session.exports.mesh("s.stl", smoothed); },
        [&] { run_command(session, parse_line("certificate s"), nullptr, command_table()); },
        [&] { session.surfaces.compare("s"); },
    };
    for (const auto& work : works) {
        pauses = 0;
        CHECK_THROWS_AS(work(), Canceled);
        CHECK(pauses == 1);
    }
    machine.on_work = {};
    CHECK(session.scene.surfaces.size() == 1);
    CHECK(session.surfaces.find("s")->components == largest);
    CHECK(picture() == before);
    CHECK_NOTHROW(session.surfaces.set_components("s", {}));
    CHECK(picture() != before);
}
