// Tests that a session's counts equal the counts of its recording.
#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "host/inspect/model/recorded_work.hpp"
#include "host/machine/machine.hpp"
#include "host/session/live_work.hpp"
#include "host/timing/simulate.hpp"
#include "tests/host/inspect/recorded_machine.hpp"
#include "tests/ringbus/scratch_folder.hpp"

using namespace pxpl5;
using namespace pxpl5::host;

namespace {

Topology plan(int gps, int renderers) {
    Topology topology;
    topology.gp.count = gps;
    topology.renderer.count = renderers;
    topology.frame_buffer.count = 1;
    topology.record = Recording::full;
    return topology;
}

/// Every step of `live` is the same in `recorded`, and nothing else was asked for.
void check_same(const timing::RunWork& live, const timing::RunWork& recorded) {
    CHECK(live.missing.empty());
    CHECK(recorded.missing.empty());
    REQUIRE(live.steps.size() == recorded.steps.size());
    for (std::size_t i = 0; i < live.steps.size(); ++i) {
        CAPTURE(i);
        REQUIRE(live.steps[i].index() == recorded.steps[i].index());
        CHECK(live.steps[i] == recorded.steps[i]);
    }
}

/// Two surfaces, one of them behind a screen door; `samples` passes.
timing::RunWork use(Session& session, int samples) {
    session.volumes.load("phantom:letters");
    session.scene.size = {300, 200};
    session.scene.camera.angles = {30, 20};
    session.scene.samples = samples;
    const double middle = (session.volumes.volume().minimum + session.volumes.volume().maximum) / 2;
    session.surfaces.set("outer", middle, CaseRule::watertight, {200, 180, 160});
    session.surfaces.set("inner", middle * 1.2, CaseRule::lorensen1987, {90, 120, 160});
    Surface outer = *session.surfaces.find("outer");
    outer.opacity = 8;
    outer.cull_back = true;
    session.surfaces.set_style(outer);
    return live_work(session);
}

}  // namespace

TEST_CASE("a machine of processes: live and recorded agree, work and modelled time") {
    const test::ScratchFolder folder;
    MachineOptions options;
    options.binaries = PXPL5_BIN_DIR;
    options.run_base = folder / "run";
    Machine machine(plan(3, 2), options);
    Session session(machine);
    const timing::RunWork live = use(session, 1);
    machine.shutdown();
    const timing::RunWork recorded =
        inspect::recorded_work(inspect::RecordedRun::open(machine.run_folder()));
    REQUIRE(live.steps.size() == 1 + 2 + 1);
    check_same(live, recorded);

    const timing::Machine modelled = timing::machine_of(load_topology("paper-1993"));
    const timing::RunTime a = timing::simulate(modelled, live);
    const timing::RunTime b = timing::simulate(modelled, recorded);
    CHECK(a.events == b.events);
    REQUIRE(a.steps.size() == b.steps.size());
    for (std::size_t i = 0; i < a.steps.size(); ++i) {
        CHECK(a.steps[i].begin == b.steps[i].begin);
        CHECK(a.steps[i].end == b.steps[i].end);
    }
}

TEST_CASE("passes of a picture, and a scene without a volume: live and recorded agree") {
    test::RecordedMachine passes(plan(2, 3));
    const timing::RunWork live = use(passes.session, 4);
    REQUIRE(live.steps.size() == 1 + 2 + 4);
    check_same(live, inspect::recorded_work(passes.run()));

    test::RecordedMachine scene(plan(3, 1));
    scene.session.scene.size = {150, 140};
    scene.session.volumes.load(std::string(PXPL5_SOURCE_DIR) +
                               "/host/phigs/archives/molecule.phigs");
    const timing::RunWork shown = live_work(scene.session);
    check_same(shown, inspect::recorded_work(scene.run()));
}

TEST_CASE("surfaces in parts, and of which triangles are hidden: live and recorded agree") {
    test::RecordedMachine recorded(plan(3, 2));
    Session& session = recorded.session;
    session.volumes.load("phantom:letters");
    session.scene.size = {150, 140};
    session.scene.tint_gaps = true;
    const double middle = (session.volumes.volume().minimum + session.volumes.volume().maximum) / 2;
    session.surfaces.set("letters", middle, CaseRule::watertight, {200, 180, 160});
    ComponentFilter largest;
    largest.kind = ComponentFilter::Kind::largest;
    session.surfaces.set_components("letters", largest);
    const timing::RunWork live = live_work(session);
    check_same(live, inspect::recorded_work(recorded.run()));
}
