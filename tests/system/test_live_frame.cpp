// Questions about the frame of a running machine: its processes record it, the host executes it
// again.
#include <doctest/doctest.h>

#include "host/commands/commands.hpp"
#include "host/inspect/why/live_frame.hpp"
#include "host/machine/machine.hpp"
#include "tests/ringbus/scratch_folder.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using inspect::LiveFrame;

namespace {

/// A ball on a machine of two GPs and two Renderers, whose processes record.
struct RecordedBall {
    explicit RecordedBall(int frame_buffers)
        : machine(topology_of(frame_buffers), options_in(folder)), session(machine) {
        session.volumes.load("phantom:sphere");
        session.scene.size = {256, 256};
        session.surfaces.set("ball", 0.5, CaseRule::watertight, {200, 100, 50});
    }
    static Topology topology_of(int frame_buffers) {
        Topology topology;
        topology.gp.count = topology.renderer.count = 2;
        topology.frame_buffer.count = frame_buffers;
        topology.record = Recording::flight;
        return topology;
    }
    static MachineOptions options_in(const test::ScratchFolder& folder) {
        MachineOptions options;
        options.binaries = PXPL5_BIN_DIR;
        options.run_base = folder / "run";
        return options;
    }

    test::ScratchFolder folder;
    Machine machine;
    Session session;
};

}  // namespace

TEST_CASE("a scrubbed region ends as the frame shows it, and is kept until the scene changes") {
    RecordedBall ball(1);
    Session& session = ball.session;
    const Picture picture = session.frames.draw();

    const inspect::ScrubView end = LiveFrame::of(session).scrub(140, 130, {});
    const std::uint32_t frame = session.frames.last().frame;
    CHECK(end.at == end.count);
    CHECK(end.field == "rgb");
    int differ = 0;
    for (int i = 0; i < 128 * 128; ++i) {
        const int x = end.x0_px + i % 128, y = end.y0_px + i / 128;
        const std::uint32_t there = picture.rgba[static_cast<std::size_t>(y * 256 + x)];
        differ += ((there ^ end.rgba[static_cast<std::size_t>(i)]) & 0xFFFFFF) != 0 ? 1 : 0;
    }
    CHECK(differ == 0);
    const inspect::ScrubView begin = LiveFrame::of(session).scrub(140, 130, {.at = 0, .field = {}});
    CHECK(begin.count == end.count);
    REQUIRE(!begin.lines.empty());
    CHECK(begin.lines.front().at == 0);
    CHECK(begin.lines.front().address == "prologue+0");
    CHECK(LiveFrame::of(session).why(140, 130).text.find("triangle") != std::string::npos);
    CHECK(session.frames.last().frame == frame);  // Nothing was drawn for these questions.
    session.scene.camera.angles.azimuth_deg += 10;
    LiveFrame::of(session).why(140, 130);
    CHECK(session.frames.last().frame == frame + 1);
    const auto why = [&] { return run_command(session, parse_line("why 140 130")).text; };
    CHECK(why().starts_with("Pixel (140, 130)"));
    session.scene.samples = 4;
    CHECK(
        why().starts_with("Pictures show the mean of 4 samples of the pixel; this explains one "));
    ball.machine.shutdown();
}

TEST_CASE("`why` names the slice and the voxel that a pixel shows") {
    RecordedBall ball(1);
    Session& session = ball.session;
    run_command(session, parse_line("remove ball"));
    run_command(session, parse_line("view superior"));
    run_command(session, parse_line("planes z=20 window=2 level=0.5"));
    const std::string text = run_command(session, parse_line("why 140 130")).text;
    CHECK_MESSAGE(text.find("slice z 20, black at -0.5, white at 1.5") != std::string::npos, text);
    CHECK_MESSAGE(text.find("of a slice, voxel (") != std::string::npos, text);
    CHECK_MESSAGE(text.find(", 20) ") != std::string::npos, text);
    ball.machine.shutdown();
}

TEST_CASE("questions about a pixel of the right eye are answered from its own frame buffer") {
    RecordedBall ball(2);
    Session& session = ball.session;
    session.scene.stereo.mode = StereoMode::side_by_side;
    const Picture pair = session.frames.draw();
    REQUIRE(pair.width == 512);

    const inspect::ScrubView end = LiveFrame::of(session).scrub(256 + 140, 130, {});
    REQUIRE(end.y0_px == 256 + 128);  // The right eye's view lies below the left eye's.
    int differ = 0;
    for (int i = 0; i < 128 * 128; ++i) {
        const int x = 256 + end.x0_px + i % 128, y = end.y0_px - 256 + i / 128;
        const std::uint32_t there = pair.rgba[static_cast<std::size_t>(y * 512 + x)];
        differ += ((there ^ end.rgba[static_cast<std::size_t>(i)]) & 0xFFFFFF) != 0 ? 1 : 0;
    }
    CHECK(differ == 0);
    const std::string why = LiveFrame::of(session).why(256 + 140, 130).text;
    CHECK_MESSAGE(why.find("as in the recorded frame") != std::string::npos, why);
    ball.machine.shutdown();
}
