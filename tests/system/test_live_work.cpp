// Tests the counted work of a session: equal for any machine, and equal to the work done.
#include <doctest/doctest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <tuple>

#include "host/machine/machine.hpp"
#include "host/session/live_work.hpp"
#include "tests/system/simulated_machine.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using namespace pxpl5::host::timing;

namespace {

Topology plan(int gps, int renderers, std::uint64_t seed = 1) {
    Topology topology;
    topology.gp.count = gps;
    topology.renderer.count = renderers;
    topology.frame_buffer.count = 1;
    topology.seed = seed;
    return topology;
}

/// The letters from aside, one surface behind a screen door; and what the machine itself reports.
struct Result {
    RunWork work;
    std::vector<FrameWork> passes;  ///< Passes of a picture with 4 samples.
    SurfaceReport outer;
    FrameReport frame;  ///< The frame in `work`.
    std::int64_t pass_instructions = 0;
};

Result result_of(MachinePort& machine) {
    Session session(machine);
    session.volumes.load("phantom:letters");
    session.scene.size = {300, 200};
    session.scene.camera.angles = {30, 20};
    const double middle = (session.volumes.volume().minimum + session.volumes.volume().maximum) / 2;
    Result result;
    result.outer = session.surfaces.set("outer", middle, CaseRule::watertight, {200, 180, 160});
    session.surfaces.set("inner", middle * 1.2, CaseRule::lorensen1987, {90, 120, 160});
    Surface outer = *session.surfaces.find("outer");
    outer.opacity = 8;
    session.surfaces.set_style(outer);
    result.work = live_work(session);
    result.frame = session.frames.last();
    session.scene.samples = 4;
    result.passes = frame_work(session);
    result.pass_instructions = session.frames.last().instructions;
    return result;
}

Result simulated(const Topology& topology) {
    test::SimulatedMachine machine(topology);
    return result_of(machine);
}

template <typename Work>
const Work& step(const Result& result, std::size_t index) {
    return std::get<Work>(result.work.steps.at(index));
}

/// Equal but for who drew what.
FrameWork unassigned(FrameWork work) {
    work.assignment.clear();
    return work;
}

void check_same(const Result& a, const Result& b) {
    REQUIRE(a.work.steps.size() == 4);
    REQUIRE(b.work.steps.size() == 4);
    CHECK(step<VolumeWork>(a, 0) == step<VolumeWork>(b, 0));
    CHECK(step<BuildWork>(a, 1) == step<BuildWork>(b, 1));
    CHECK(step<BuildWork>(a, 2) == step<BuildWork>(b, 2));
    CHECK(unassigned(step<FrameWork>(a, 3)) == unassigned(step<FrameWork>(b, 3)));
    REQUIRE(a.passes.size() == b.passes.size());
    for (std::size_t i = 0; i < a.passes.size(); ++i) {
        CHECK(unassigned(a.passes[i]) == unassigned(b.passes[i]));
    }
}

const Result& least_machine() {
    static const Result result = simulated(plan(1, 1));
    return result;
}

ClassCounts sum_of(const FrameWork& work, std::size_t region) {
    ClassCounts sum;
    for (const PartWork& part : work.parts) {
        for (const ClassCounts& counts : part.classes) {
            sum += part.region == region ? counts : ClassCounts{};
        }
    }
    return sum;
}

}  // namespace

TEST_CASE("the sums over any number of nodes are those of the least machine") {
    std::set<std::vector<std::uint16_t>> assignments;
    for (const int gps : {1, 2, 3, 7}) {
        for (const int renderers : {1, 2, 5}) {
            CAPTURE(gps);
            CAPTURE(renderers);
            const Result result = simulated(plan(gps, renderers, 10 * gps + renderers));
            check_same(result, least_machine());
            assignments.insert(step<FrameWork>(result, 3).assignment);
        }
    }
    CHECK(assignments.size() == 3);  // So many numbers of Renderers.
}

TEST_CASE("real processes count what simulated ones count") {
    MachineOptions options;
    options.binaries = PXPL5_BIN_DIR;
    options.run_base =
        std::filesystem::temp_directory_path() / ("pxpl5-live-work-" + std::to_string(getpid()));
    {
        Machine machine(plan(3, 2), options);
        check_same(result_of(machine), least_machine());
        machine.shutdown();
    }
    std::filesystem::remove_all(options.run_base);
}

TEST_CASE("builds hold what extraction reports, slab by slab") {
    const Result& result = least_machine();
    const auto& volume = step<VolumeWork>(result, 0);
    const auto& build = step<BuildWork>(result, 1);
    REQUIRE(build.slabs.size() == volume.nz - 1);
    SlabWork sum;
    for (std::size_t s = 0; s < build.slabs.size(); ++s) {
        CHECK(build.slabs[s].slab == s);
        sum.triangles += build.slabs[s].triangles;
        sum.vertices += build.slabs[s].vertices;
        sum.cells_active += build.slabs[s].cells_active;
    }
    CHECK(std::int64_t(sum.triangles) == result.outer.triangles);
    CHECK(std::int64_t(sum.vertices) == result.outer.vertices);
    CHECK(std::int64_t(sum.cells_active) == result.outer.cells_active);
    CHECK(sum.triangles > 1000);
    CHECK(build.revision == 1);
    CHECK(step<BuildWork>(result, 2).surface != build.surface);
}

TEST_CASE("a frame's parts sum up to what its Renderers report, region by region") {
    const Result& result = least_machine();
    const auto& work = step<FrameWork>(result, 3);
    REQUIRE(work.regions() == 6);
    CHECK(work.assignment == std::vector<std::uint16_t>(6, 0));
    CHECK(work.reads_out);
    std::uint64_t instructions = 0;
    for (std::size_t region = 0; region < 6; ++region) {
        CAPTURE(region);
        CHECK(sum_of(work, region).cycles == result.frame.region_cycles.at(region));
        instructions += sum_of(work, region).instructions;
    }
    CHECK(std::int64_t(instructions) == result.frame.instructions);
    for (const PartWork& part : work.parts) {
        CHECK((part.port_cycles > 0) == (part.kind == PartKind::end_of_region));
        CHECK(part.backing_cycles == 0);
    }
}

TEST_CASE("a frame draws each slab's triangles, and no more of them than there are") {
    const Result& result = least_machine();
    const auto& work = step<FrameWork>(result, 3);
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint64_t> drawn, emitted;
    for (const DrawnSlab& slab : work.drawn) {
        CHECK(drawn.emplace(std::pair(slab.surface, slab.slab), slab.primitives).second);
    }
    CHECK(std::ranges::is_sorted(
        work.drawn, {}, [](const DrawnSlab& slab) { return std::tuple(slab.surface, slab.slab); }));
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint64_t> built;
    for (const std::uint32_t surface : {0U, 1U}) {
        for (const SlabWork& slab : step<BuildWork>(result, 1 + surface).slabs) {
            if (slab.triangles > 0) {
                built[{surface, slab.slab}] = slab.triangles;
            }
        }
    }
    CHECK(drawn == built);
    for (const PartWork& part : work.parts) {
        CHECK(part.words == 34 * part.primitives);
        if (part.kind == PartKind::segment) {
            emitted[{part.surface, part.slab}] += part.primitives;
            CHECK(part.primitives > 0);
            CHECK(drawn.contains({part.surface, part.slab}));
        }
    }
    CHECK(emitted.size() > 20);
}

TEST_CASE("each pass of a picture is counted by itself, and the last reads out") {
    const Result& result = least_machine();
    REQUIRE(result.passes.size() == 4);
    std::uint64_t instructions = 0;
    for (std::size_t i = 0; i < 4; ++i) {
        const FrameWork& work = result.passes[i];
        CHECK(work.reads_out == (i == 3));
        CHECK(work.frame == result.passes[0].frame + i);
        std::uint64_t port_cycles = 0, backing_cycles = 0;
        for (const PartWork& part : work.parts) {
            port_cycles += part.port_cycles;
            backing_cycles += part.backing_cycles;
        }
        CHECK((port_cycles > 0) == (i == 3));
        CHECK(backing_cycles > 0);
        for (std::size_t region = 0; region < 6; ++region) {
            instructions += sum_of(work, region).instructions;
        }
    }
    CHECK(std::int64_t(instructions) == result.pass_instructions);
}

TEST_CASE("a scene of an archive has a frame, and no volume") {
    test::SimulatedMachine machine(plan(2, 2));
    Session session(machine);
    session.volumes.load(std::string(PXPL5_SOURCE_DIR) + "/host/phigs/archives/molecule.phigs");
    session.scene.size = {300, 200};
    const RunWork run = live_work(session);
    REQUIRE(run.steps.size() == 1);
    const auto& work = std::get<FrameWork>(run.steps[0]);
    CHECK_FALSE(work.drawn.empty());
    CHECK_THROWS_AS(volume_work(session), RequestError);
    CHECK_THROWS_AS(build_work(session, "atoms"), RequestError);
}

TEST_CASE("nothing is drawn of an empty scene but its regions") {
    test::SimulatedMachine machine(plan(2, 2));
    Session session(machine);
    session.volumes.load("phantom:letters");
    session.scene.size = {130, 100};
    const RunWork run = live_work(session);
    REQUIRE(run.steps.size() == 2);
    const auto& work = std::get<FrameWork>(run.steps[1]);
    CHECK(work.drawn.empty());
    REQUIRE(work.parts.size() == 4);
    for (const PartWork& part : work.parts) {
        CHECK((part.kind == PartKind::prologue || part.kind == PartKind::end_of_region));
        CHECK(part.primitives + part.words == 0);
    }
}
