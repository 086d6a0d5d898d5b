#include <doctest/doctest.h>

#include <cstring>

#include "host/base/error.hpp"
#include "host/inspect/record/region_walk.hpp"
#include "renderer_firmware/fast/fast.hpp"
#include "tests/host/inspect/recorded_machine.hpp"

using namespace pxpl5;
namespace schema = bus::schema;
namespace inspect = host::inspect;

namespace {

host::Topology machine_of(int gps, int renderers) {
    host::Topology topology;
    topology.gp.count = gps;
    topology.renderer.count = renderers;
    topology.frame_buffer.count = 1;
    return topology;
}

}  // namespace

TEST_CASE("regions of a recorded frame, executed again, give the pixels that were sent") {
    test::RecordedMachine recorded(machine_of(2, 3));
    host::Session& session = recorded.session;
    session.scene.size = {300, 200};
    session.volumes.load("phantom:sphere");
    session.surfaces.set("ball", 100, CaseRule::watertight, {200, 100, 50});
    session.frames.draw();
    const host::Picture picture = session.frames.draw();

    const inspect::RecordedRun run = recorded.run();
    REQUIRE(run.frames().size() == 2);
    const inspect::RecordedFrame frame = run.frame(run.frames().back());
    CHECK(frame.missing.empty());
    CHECK(frame.regions.size() == 6);
    std::size_t compared = 0, covered = 0;
    for (const auto& [number, region] : frame.regions) {
        renderer::fast::Fast executor;
        inspect::RegionWalk walk(region.plan, executor);
        while (!walk.done()) {
            walk.run_part();
        }
        for (int y = 0; y < 128 && region.place.y0_px + y < 200; ++y) {
            for (int x = 0; x < 128 && region.place.x0_px + x < 300; ++x, ++compared) {
                const std::size_t at = static_cast<std::size_t>((region.place.y0_px + y) * 300 +
                                                                region.place.x0_px + x);
                REQUIRE((executor.field(x, y, 64, 24)) == (picture.rgba[at] & 0xFFFFFF));
                covered += executor.field(x, y, 0, 8);
            }
        }
    }
    CHECK(compared == 300 * 200);
    CHECK(covered > 1000);
}

TEST_CASE("a walk of single steps ends where whole parts do") {
    test::RecordedMachine recorded(machine_of(2, 1));
    host::Session& session = recorded.session;
    session.scene.size = {128, 128};
    session.volumes.load("phantom:sphere");
    session.surfaces.set("ball", 100, CaseRule::watertight, {200, 100, 50});
    session.frames.draw();
    const inspect::RecordedFrame frame = recorded.run().frame(0);
    const inspect::RecordedRegion& region = frame.regions.at(0);
    renderer::fast::Fast stepped, whole;
    inspect::RegionWalk steps(region.plan, stepped), parts(region.plan, whole);
    std::uint64_t count = 0;
    for (; !steps.done(); ++count) {
        steps.step();
    }
    while (!parts.done()) {
        parts.run_part();
    }
    CHECK(count == parts.counts().instructions);
    CHECK(steps.counts().cycles == parts.counts().cycles);
    const auto* tile = frame.pixels.find(0)->second.as<schema::RegionPixels>()->tiles()->Get(0);
    CHECK(count == tile->instructions());
    CHECK(parts.counts().cycles == tile->cycles());
    for (int y = 0; y < 128; ++y) {
        for (int x = 0; x < 128; ++x) {
            REQUIRE(stepped.field(x, y, 64, 24) == whole.field(x, y, 64, 24));
        }
    }
}

TEST_CASE("a primitive holds the addresses from its SETENABS to the next") {
    test::RecordedMachine recorded(machine_of(3, 1));
    host::Session& session = recorded.session;
    session.scene.size = {128, 128};
    session.volumes.load("phantom:sphere");
    session.surfaces.set("ball", 100, CaseRule::watertight, {200, 100, 50});
    session.frames.draw();
    const inspect::RecordedFrame frame = recorded.run().frame(0);
    const inspect::RecordedRegion& region = frame.regions.at(0);
    const std::vector<inspect::Primitive> primitives = inspect::primitives_of(frame, region);
    std::size_t words = 0;
    for (const auto& part : region.plan.parts) {
        words += part.kind == PartKind::segment ? part.segment.words.size() : 0;
    }
    REQUIRE(primitives.size() == words / 34);
    const inspect::Primitive& one = primitives.at(primitives.size() / 2);
    CHECK(inspect::primitive_at(primitives, {one.part, one.first_word}) == &one);
    CHECK(inspect::primitive_at(primitives, {one.part, one.first_word + 33}) == &one);
    CHECK(inspect::primitive_at(primitives, {0, 0}) == nullptr);
    CHECK(inspect::primitive_at(primitives, {region.plan.parts.size() - 1, 0}) == nullptr);
}

TEST_CASE("the volume of a frame is put together from the slices of all GPs") {
    test::RecordedMachine recorded(machine_of(3, 1));
    host::Session& session = recorded.session;
    session.scene.size = {128, 128};
    session.volumes.load("phantom:torus");
    session.frames.draw();
    session.volumes.load("phantom:sphere");
    session.frames.draw();
    const inspect::RecordedRun run = recorded.run();
    const auto volume = run.volume(1);
    REQUIRE(volume);
    const host::Volume& held = session.volumes.volume();
    for (int z = 0; z < held.nz; z += 5) {
        const auto value = volume->value(held.nx / 2, held.ny / 3, z);
        REQUIRE(value);
        std::int16_t expected = 0;
        const std::size_t voxel =
            static_cast<std::size_t>((z * held.ny + held.ny / 3) * held.nx + held.nx / 2);
        REQUIRE(held.type == Scalar::int16);
        std::memcpy(&expected, held.values.data() + 2 * voxel, 2);
        CHECK(*value == expected);
    }
    CHECK(run.volume(0)->header.as<schema::VolumeHeader>()->name()->str() !=
          volume->header.as<schema::VolumeHeader>()->name()->str());
}

TEST_CASE("traces that are cut before the Topology are refused with the reason of each cut") {
    test::RecordedMachine recorded(machine_of(1, 1));
    std::vector<inspect::NodeTrace> traces = recorded.traces.traces();
    REQUIRE(traces.size() == 4);
    for (inspect::NodeTrace& trace : traces) {
        trace.entries.clear();
    }
    const std::string refusal = "none of 4 traces describes the machine";
    CHECK_THROWS_WITH(inspect::RecordedRun{traces}, refusal.c_str());
    traces[1].cut = "the last record has 9 of 40 bytes";
    CHECK_THROWS_WITH(inspect::RecordedRun{traces},
                      (refusal + "; gp-0: the last record has 9 of 40 bytes").c_str());
}

TEST_CASE("what is not in a run is refused by name") {
    test::RecordedMachine recorded(machine_of(1, 1));
    recorded.session.scene.size = {130, 20};
    recorded.session.volumes.load("phantom:sphere");
    recorded.session.frames.draw();
    const inspect::RecordedRun run = recorded.run();
    CHECK_THROWS_WITH(run.frame(7), "frame 7 is not in this run; it has 0");
    const inspect::RecordedFrame frame = run.frame(0);
    CHECK(frame.region_at(129, 19).number == 1);
    CHECK_THROWS_WITH(frame.region_at(130, 0),
                      "pixel (130, 0) is outside of frame 0, which has 130 x 20 pixels");
}
