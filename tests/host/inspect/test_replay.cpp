// Replaying recorded frames: every pixel, count and digest again, and what differs by name.
#include "host/inspect/replay/replay.hpp"

#include <doctest/doctest.h>

#include "host/commands/text/picture_text.hpp"
#include "host/inspect/step/region_stepper.hpp"
#include "tests/host/inspect/recorded_machine.hpp"
#include "tests/host/inspect/recorded_sphere.hpp"

using namespace pxpl5;
namespace schema = bus::schema;
namespace inspect = host::inspect;

namespace {

inspect::ReplayOptions on_both() {
    inspect::ReplayOptions options;
    options.executors = inspect::parse_executors("both");
    return options;
}

}  // namespace

TEST_CASE("a replay gives the frames again that the session saw, on both executors") {
    test::RecordedMachine recorded(test::machine_of(3, 2));
    std::vector<std::uint64_t> digests;
    test::set_up_sphere(recorded.session, {300, 150});
    for (const double azimuth : {0.0, 50.0}) {
        recorded.session.scene.camera.angles.azimuth_deg = azimuth;
        digests.push_back(host::picture_digest(recorded.session.frames.draw()));
    }
    REQUIRE(digests[0] != digests[1]);
    std::size_t told = 0;
    const inspect::ReplayReport report =
        inspect::replay(recorded.run(), on_both(), [&](const inspect::FrameReplay&) { ++told; });
    CHECK(report.agrees());
    CHECK(report.missing.empty());
    REQUIRE(report.frames.size() == 4);
    CHECK(told == 4);
    for (std::size_t i = 0; i < 4; ++i) {
        CHECK(report.frames[i].digest == digests[i / 2]);
        CHECK(report.frames[i].recorded == digests[i / 2]);
        CHECK(report.frames[i].compared() == 6);
    }
}

TEST_CASE("both eyes of a pair are replayed from the traces of two frame buffers") {
    host::Topology topology = test::machine_of(2, 3);
    topology.frame_buffer.count = 2;
    test::RecordedMachine recorded(topology);
    test::set_up_sphere(recorded.session, {200, 150});
    recorded.session.frames.draw();
    recorded.session.scene.stereo.mode = host::StereoMode::side_by_side;
    const host::Picture pair = recorded.session.frames.draw();
    const inspect::RecordedRun run = recorded.run();
    CHECK(run.frame_buffer_count() == 2);
    const inspect::ReplayReport report = inspect::replay(run, {});
    CHECK(report.agrees());
    REQUIRE(report.frames.size() == 2);
    CHECK(report.frames[0].compared() == 4);  // One view of 2 x 2 regions.
    CHECK(report.frames[1].compared() == 8);
    CHECK(report.frames[1].digest == report.frames[1].recorded);

    const inspect::RecordedFrame frame = run.frame(1);
    const std::span<const std::uint32_t> picture = inspect::picture_of(frame);
    REQUIRE(picture.size() == 2 * 200 * 150);
    std::size_t wrong = 0;
    for (std::size_t p = 0; p < picture.size(); ++p) {  // Stacked here, side by side there.
        const std::size_t eye = p / (200 * 150), row = p / 200 % 150;
        wrong += picture[p] == pair.rgba[row * 400 + eye * 200 + p % 200] ? 0 : 1;
    }
    CHECK(wrong == 0);
}

TEST_CASE("a wrong pixel of the second frame buffer's picture is named where the pair has it") {
    host::Topology topology = test::machine_of(1, 2);
    topology.frame_buffer.count = 2;
    test::RecordedMachine recorded(topology);
    test::set_up_sphere(recorded.session, {100, 100});
    recorded.session.scene.stereo.mode = host::StereoMode::rows;
    recorded.session.frames.draw();
    std::vector<inspect::NodeTrace> traces = recorded.traces.traces();
    int parts = 0;
    test::change<schema::FrameDone>(traces, [&](schema::FrameDoneT& done) {
        done.pixels.back() ^= ++parts == 2 ? 0x800000 : 0;
    });
    REQUIRE(parts == 2);
    const bool is_second =
        traces.front().entries.back().header.source() == recorded.machine.frame_buffer_ids().back();
    const inspect::ReplayReport report =
        inspect::replay(inspect::RecordedRun(std::move(traces)), {});
    REQUIRE_FALSE(report.agrees());
    const std::string text = inspect::answer_of(report.frames[0]).text();
    CHECK_MESSAGE(
        text.find(is_second ? "pixel (99, 199): #" : "pixel (99, 99): #") != std::string::npos,
        text);
}

TEST_CASE("one wrong bit of a recorded pixel is found, and named in the picture's coordinates") {
    const test::TracedSphere traced({200, 150}, 3, 2);
    std::vector<inspect::NodeTrace> traces = traced.traces();
    // Region 3 lies at (128, 128).
    test::change<schema::RegionPixels>(traces, [](schema::RegionPixelsT& pixels) {
        for (std::size_t i = 0; i < pixels.tiles.size(); ++i) {
            if (pixels.tiles[i].region() == 3) {
                pixels.pixels[i * 16384 + 5 * 128 + 9] ^= 0x0400;
            }
        }
    });
    const inspect::ReplayReport report =
        inspect::replay(inspect::RecordedRun(std::move(traces)), on_both());
    CHECK_FALSE(report.agrees());
    for (const inspect::FrameReplay& frame : report.frames) {
        REQUIRE(frame.first_difference() != nullptr);
        CHECK(frame.first_difference()->region == 3);
        const std::string text = inspect::answer_of(frame).text();
        CHECK(text.find("pixel (137, 133): #") != std::string::npos);
        CHECK(text.find("in the recording (bit 2)") != std::string::npos);
    }
}

TEST_CASE("a wrong count of instructions or cycles is a difference") {
    const test::TracedSphere traced({100, 100}, 1, 1);
    for (const bool cycles : {false, true}) {
        std::vector<inspect::NodeTrace> traces = traced.traces();
        test::change<schema::RegionPixels>(traces, [&](schema::RegionPixelsT& pixels) {
            const schema::RegionTile& t = pixels.tiles[0];
            pixels.tiles[0] =
                schema::RegionTile(t.region(), t.has_depths(), t.cycles() + (cycles ? 1 : 0),
                                   t.instructions() + (cycles ? 0 : 1));
        });
        CHECK_FALSE(inspect::replay(inspect::RecordedRun(std::move(traces)), {}).agrees());
    }
}

TEST_CASE("a wrong pixel that only the host got is a difference") {
    const test::TracedSphere traced({100, 100}, 1, 1);
    std::vector<inspect::NodeTrace> traces = traced.traces();
    test::change<schema::FrameDone>(
        traces, [](schema::FrameDoneT& done) { done.pixels.back() ^= 0x800000; });
    const inspect::ReplayReport report =
        inspect::replay(inspect::RecordedRun(std::move(traces)), {});
    REQUIRE_FALSE(report.agrees());
    CHECK(report.frames[0].digest != report.frames[0].recorded);
    CHECK(inspect::answer_of(report.frames[0]).text().find("pixel (99, 99): #") !=
          std::string::npos);
}

TEST_CASE("what a trace lacks is said, and the rest is replayed") {
    const test::TracedSphere traced({200, 100}, 2, 2);
    std::vector<inspect::NodeTrace> traces = traced.traces();
    for (inspect::NodeTrace& node : traces) {
        if (node.info.role == schema::Role::renderer && node.info.index == 1) {
            std::erase_if(node.entries, [](const bus::trace::Entry& entry) {
                return entry.kind() == bus::Body::RegionPrograms;
            });
            node.cut = "ends at byte 1234";
        }
    }
    const inspect::RecordedRun run(std::move(traces));
    const inspect::ReplayReport report = inspect::replay(run, {});
    CHECK(report.agrees());
    CHECK(report.compared() == 1);
    CHECK_FALSE(report.frames[0].digest);
    const std::string summary = inspect::summary_of(report).text();
    CHECK(summary.find("renderer-1: ends at byte 1234") != std::string::npos);
    CHECK(summary.find("programs of 0 of 2 GPs") != std::string::npos);
    CHECK(summary.find("All comparisons agree: 1 region") != std::string::npos);

    inspect::ReplayOptions other;
    other.selection.renderers = {{1, 1}};
    CHECK_THROWS_AS(inspect::replay(run, other), host::RequestError);
}

TEST_CASE("executors are known by name") {
    using inspect::ExecutorKind;
    CHECK(inspect::parse_executors("both") ==
          std::vector{ExecutorKind::reference, ExecutorKind::fast});
    CHECK(inspect::parse_executors("fast,reference") ==
          std::vector{ExecutorKind::fast, ExecutorKind::reference});
    CHECK_THROWS_WITH(inspect::parse_executors("slow"),
                      "executor 'slow'; it must be reference, fast, sse4, avx2, avx512 or both");
}

TEST_CASE("a picture of several samples is replayed pass behind pass, on both executors") {
    test::RecordedMachine recorded(test::machine_of(2, 2));
    test::set_up_sphere(recorded.session, {300, 150});
    recorded.session.frames.draw();
    const auto digest = host::picture_digest(*recorded.session.frames.draw_samples(4));
    const inspect::RecordedRun run = recorded.run();
    const inspect::ReplayReport report = inspect::replay(run, on_both());
    CHECK(report.agrees());
    CHECK(report.missing.empty());
    REQUIRE(report.frames.size() == 10);
    for (std::size_t i = 2; i < 8; ++i) {
        CHECK_FALSE(report.frames[i].digest.has_value());
        CHECK(report.frames[i].compared() == 6);  // Their counts.
    }
    for (std::size_t i = 8; i < 10; ++i) {
        CHECK(report.frames[i].pass == "sample 4 of 4");
        CHECK(report.frames[i].digest == digest);
        CHECK(report.frames[i].recorded == digest);
    }
    // Stepped through, the last pass ends with the mean, too.
    const inspect::RecordedFrame last = run.frame(4);
    inspect::RegionStepper stepper(last.regions.at(1));
    stepper.seek_end();
    const auto picture = inspect::picture_of(last);
    CHECK(stepper.executor().field(0, 60, 64, 24) == (picture[60 * 300 + 128] & 0xFFFFFF));
    CHECK(inspect::run_region(last.regions.at(1).plan,
                              *inspect::make_executor(inspect::ExecutorKind::fast))
              .pixels.at(60 * 128) != (picture[60 * 300 + 128] & 0xFFFFFF));
}

TEST_CASE("a pass of which earlier ones are not recorded is named with the frames it needs") {
    test::RecordedMachine recorded(test::machine_of(1, 1));
    test::set_up_sphere(recorded.session, {100, 100});
    recorded.session.frames.draw_samples(4);
    std::vector<inspect::NodeTrace> traces = recorded.traces.traces();
    for (inspect::NodeTrace& node : traces) {
        std::erase_if(node.entries, [&](const bus::trace::Entry& entry) {
            const auto* begin = node.load(entry).as<schema::BeginFrame>();
            return begin != nullptr && begin->draw()->frame() == 1;
        });
    }
    const inspect::RecordedRun run(std::move(traces));
    CHECK(run.frame(0).missing.empty());
    const inspect::RecordedFrame last = run.frame(3);
    CHECK(last.regions.empty());
    REQUIRE(last.missing.size() == 1);
    CHECK(last.missing[0] ==
          "renderer-0: sample 4 of 4 adds to the sums of frames 0 to 2, not all "
          "of which are recorded");
}
