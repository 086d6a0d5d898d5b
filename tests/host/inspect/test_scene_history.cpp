// Spheres of an archive compute in scratch memory: only what is shown counts as stored.
#include <doctest/doctest.h>

#include <map>
#include <string>
#include <vector>

#include "host/base/error.hpp"
#include "host/inspect/why/pixel_history.hpp"
#include "host/inspect/why/why.hpp"
#include "isa/contract/region_layout.hpp"
#include "renderer_firmware/fast/fast.hpp"
#include "tests/host/inspect/recorded_machine.hpp"

using namespace pxpl5;
namespace inspect = host::inspect;
namespace layout = isa::region;

namespace {

constexpr int step_px = 11;  // Of the pixels looked at.

host::Topology small_machine() {
    host::Topology topology;
    topology.gp.count = 2;
    topology.renderer.count = 1;
    topology.frame_buffer.count = 1;
    return topology;
}

std::string archive(const std::string& name) {
    return std::string(PXPL5_SOURCE_DIR) + "/host/phigs/archives/" + name + ".phigs";
}

/// The primitive that changed each pixel's depth last, by a walk of the fast executor.
std::map<std::pair<int, int>, std::size_t> last_writers(const inspect::RecordedFrame& frame,
                                                        const inspect::RecordedRegion& region) {
    const std::vector<inspect::Primitive> primitives = inspect::primitives_of(frame, region);
    renderer::fast::Fast executor;
    inspect::RegionWalk walk(region.plan, executor);
    std::map<std::pair<int, int>, std::size_t> writers;
    std::map<std::pair<int, int>, std::uint64_t> depth;
    while (!walk.done()) {
        const inspect::Address at = walk.at();
        const inspect::Primitive* primitive = inspect::primitive_at(primitives, at);
        const isa::Op op = walk.next().op;
        walk.step();
        if (op == isa::Op::set_enabs || walk.done()) {
            continue;
        }
        for (int y = 0; y < region_px; y += step_px) {
            for (int x = 0; x < region_px; x += step_px) {
                const auto z = executor.field(x, y, layout::z.address, layout::z.width);
                if (primitive != nullptr && z != depth[{x, y}]) {
                    writers[{x, y}] = primitive->number;
                }
                depth[{x, y}] = z;
            }
        }
    }
    return writers;
}

}  // namespace

TEST_CASE("a pixel of an archive shows the primitive that stored its depth last") {
    for (const char* name : {"molecule", "room"}) {
        CAPTURE(name);
        test::RecordedMachine recorded(small_machine());
        recorded.session.scene.size = {128, 128};
        recorded.session.volumes.load(archive(name));
        recorded.session.frames.draw();
        const inspect::RecordedRun run = recorded.run();
        const inspect::RecordedFrame frame = run.frame(0);
        const inspect::RecordedRegion& region = frame.regions.at(0);
        const auto writers = last_writers(frame, region);
        CHECK(writers.size() > 20);
        std::size_t lost = 0;
        for (int y = 0; y < region_px; y += step_px) {
            for (int x = 0; x < region_px; x += step_px) {
                CAPTURE(x);
                CAPTURE(y);
                const inspect::PixelHistory history = inspect::history_of(frame, region, x, y);
                const inspect::PixelVisit* shown = history.shown();
                const auto writer = writers.find({x, y});
                REQUIRE((shown != nullptr) == (writer != writers.end()));
                if (shown != nullptr) {
                    CHECK(history.primitives[shown->primitive].number == writer->second);
                    CHECK(history.primitives[shown->primitive].is_of_scene);
                    CHECK(shown->z == shown->after.z);
                }
                for (const inspect::PixelVisit& visit : history.visits) {
                    lost += visit.writes.empty() ? 1 : 0;
                }
            }
        }
        CHECK_MESSAGE(lost > 0, "nothing lost a depth test: too easy");
    }
}

TEST_CASE("a frame of an archive has no volume, even if one was loaded before") {
    test::RecordedMachine recorded(small_machine());
    recorded.session.scene.size = {128, 128};
    recorded.session.volumes.load("phantom:sphere");
    recorded.session.frames.draw();
    recorded.session.volumes.load(archive("molecule"));
    recorded.session.frames.draw();
    const inspect::RecordedRun run = recorded.run();
    CHECK(run.volume(0).has_value());
    CHECK(!run.volume(1).has_value());
}
