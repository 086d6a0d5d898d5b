// A Renderer that is wrong on purpose must be found: this binary's fast executor is built with
// PXPL5_PLANTED_BUG.
#include <doctest/doctest.h>

#include "host/inspect/diff/shrink.hpp"
#include "host/inspect/replay/replay.hpp"
#include "isa/contract/triangle_shape.hpp"
#include "isa/disassemble.hpp"
#include "tests/host/inspect/recorded_sphere.hpp"

using namespace pxpl5;
namespace schema = bus::schema;
namespace inspect = host::inspect;

namespace {

/// The recording of the wrong Renderers.
const test::TracedSphere& recorded() {
    static const test::TracedSphere traced({256, 256}, 2, 2);
    return traced;
}

/// The recording as right Renderers would have made it: the reference's pixels.
std::vector<inspect::NodeTrace> healed() {
    std::vector<inspect::NodeTrace> traces = recorded().traces();
    const inspect::RecordedFrame frame = recorded().run().frame(0);
    test::change<schema::RegionPixels>(traces, [&](schema::RegionPixelsT& sent) {
        for (std::size_t i = 0; i < sent.tiles.size(); ++i) {
            const auto reference = inspect::make_executor(inspect::ExecutorKind::reference);
            const auto pixels =
                inspect::run_region(frame.regions.at(sent.tiles[i].region()).plan, *reference)
                    .pixels;
            std::ranges::copy(pixels,
                              sent.pixels.begin() + static_cast<std::ptrdiff_t>(i * region_pixels));
        }
    });
    test::change<schema::FrameDone>(traces, [](schema::FrameDoneT& done) { done.pixels.clear(); });
    return traces;
}

}  // namespace

TEST_CASE("a replay on the reference differs from what wrong Renderers drew") {
    inspect::ReplayOptions options;
    options.executors = inspect::parse_executors("both");
    const inspect::ReplayReport report = inspect::replay(recorded().run(), options);
    REQUIRE(report.frames.size() == 2);
    CHECK_FALSE(report.frames[0].agrees());
    CHECK(report.frames[1].agrees());  // The same mistake twice.
}

TEST_CASE("executors of a wrong build are told apart at the triangle that goes wrong") {
    const inspect::DiffReport report = inspect::diff_executors(recorded().run());
    REQUIRE(report.difference);
    INFO(report.difference->answer.text());
    CHECK(report.difference->answer.text().find("instructions 10 from gp-") != std::string::npos);
    CHECK(report.difference->answer.text().find("SETENABS") != std::string::npos);
    CHECK(report.difference->answer.text().find("cell (") != std::string::npos);
}

TEST_CASE("a wrong run and a right one differ, and the wrong one is named") {
    const inspect::RecordedRun wrong = recorded().run(), right(healed());
    const inspect::DiffReport report = inspect::diff_runs(right, wrong);
    REQUIRE(report.difference);
    INFO(report.difference->answer.text());
    CHECK(report.difference->level == "pixel");
    CHECK(report.difference->answer.text().find("B is wrong: renderer-") != std::string::npos);
    CHECK(report.difference->answer.text().find("this program also differs") != std::string::npos);
}

TEST_CASE("the mistake shrinks to one triangle") {
    const inspect::RecordedRun run = recorded().run();
    const inspect::DiffReport report = inspect::diff_executors(run);
    REQUIRE(report.difference);
    const inspect::RecordedFrame frame = run.frame(report.difference->frame);
    const inspect::RecordedRegion& region = frame.regions.at(*report.difference->region);
    const inspect::DiffOptions both;
    const auto found = inspect::first_divergence(region.plan, both.trusted.make, both.other.make);
    REQUIRE(found);
    const inspect::RegionPixel pixel{found->bit.x, found->bit.y};
    const inspect::Shows shows = inspect::differ_at(pixel, both.trusted, both.other);
    const inspect::Shrunk shrunk =
        inspect::shrink(inspect::whole_program(region.plan, &*found), shows);
    CAPTURE(isa::disassemble(shrunk.words));
    CHECK(isa::check(shrunk.words).ok());
    CHECK(shrunk.instructions <= 10);
    CHECK(shrunk.instructions_before > 100);
    CHECK(shows(shrunk.words));
    CHECK(isa::triangle::matches(shrunk.words.data()));
}
