// Recordings compared with one another: the first difference, and who is right.
#include "host/inspect/diff/diff.hpp"

#include <doctest/doctest.h>

#include "host/base/error.hpp"
#include "tests/host/inspect/recorded_sphere.hpp"
#include "tests/host/inspect/wrong_executors.hpp"

using namespace pxpl5;
namespace schema = bus::schema;
namespace inspect = host::inspect;

namespace {

using Traces = std::vector<inspect::NodeTrace>;

inspect::DiffReport diff(const Traces& a, const Traces& b) {
    return inspect::diff_runs(inspect::RecordedRun(a), inspect::RecordedRun(b));
}

bool has(const inspect::DiffReport& report, const std::string& text) {
    INFO(inspect::answer_of(report).text());
    const bool found = inspect::answer_of(report).text().find(text) != std::string::npos;
    CHECK(found);
    return found;
}

/// Two frames of a sphere on a machine of this size.
Traces two_frames(int gps, int renderers, double second_azimuth = 50, double isovalue = 100) {
    test::RecordedMachine recorded(test::machine_of(gps, renderers));
    test::set_up_sphere(recorded.session, {200, 150});
    recorded.session.surfaces.set("ball", isovalue, CaseRule::watertight, {200, 100, 50});
    recorded.session.frames.draw();
    recorded.session.scene.camera.angles.azimuth_deg = second_azimuth;
    recorded.session.frames.draw();
    return recorded.traces.traces();
}

}  // namespace

TEST_CASE("runs of machines of other sizes, drawing the same, do not differ") {
    const inspect::DiffReport report = diff(two_frames(1, 1), two_frames(3, 2));
    has(report, "no difference: 2 frames, 8 regions compared");
    CHECK_FALSE(report.difference);
    CHECK(report.notes.empty());
}

TEST_CASE("another isovalue, and another view, are the first difference by name") {
    const Traces a = two_frames(1, 1);
    const inspect::DiffReport other_surface = diff(a, two_frames(2, 1, 50, 120));
    REQUIRE(other_surface.difference);
    CHECK(other_surface.difference->level == "message");
    has(other_surface, "isovalue is 100 in A, isovalue is 120 in B");
    const inspect::DiffReport other_view = diff(a, two_frames(1, 2, 51));
    REQUIRE(other_view.difference);
    CHECK(other_view.difference->frame == 1);
    has(other_view, "frame 1, DrawFrame: view 0's voxel to eye is");
}

TEST_CASE("a changed word of a program is found as an instruction, with its cell") {
    const Traces a = test::TracedSphere({200, 150}, 2, 1).traces();
    Traces b = test::TracedSphere({200, 150}, 1, 2).traces();
    std::uint32_t region = 0;
    test::change<schema::RegionPrograms>(b, [&](schema::RegionProgramsT& programs) {
        if (!programs.regions.empty() && region == 0) {
            schema::RegionProgramT& program = *programs.regions.front();
            region = 1 + program.region;
            program.words.at(34 * 2 + 19) += 5;  // B of the third triangle's z store.
        }
    });
    const inspect::DiffReport report = diff(a, b);
    REQUIRE(report.difference);
    CHECK(report.difference->level == "instruction");
    CHECK(report.difference->region == region - 1);
    has(report, "TREEintoMEM m8:24 >>8");
    has(report, "in A the instruction belongs to cell (");
    has(report, "in B the instruction belongs to cell (");
}

TEST_CASE("a slab that one run lacks is found") {
    const Traces a = test::TracedSphere({100, 100}, 1, 1).traces();
    Traces b = a;
    test::change<schema::RegionPrograms>(b, [](schema::RegionProgramsT& programs) {
        auto& segments = programs.regions.front()->segments;
        segments.erase(segments.begin() + 3);
    });
    const inspect::DiffReport report = diff(a, b);
    REQUIRE(report.difference);
    CHECK(report.difference->level == "message");
    has(report, "only A has this program: surface 0, slab ");
    has(diff(b, a), "only B has this program: surface 0, slab ");
}

TEST_CASE("pixels that differ are found to the bit, and the wrong run is named") {
    const test::TracedSphere traced({200, 150}, 2, 2);
    Traces wrong = traced.traces();
    test::change<schema::RegionPixels>(wrong, [](schema::RegionPixelsT& pixels) {
        for (std::size_t i = 0; i < pixels.tiles.size(); ++i) {
            if (pixels.tiles[i].region() == 1) {
                pixels.pixels[i * 16384 + 70 * 128 + 3] ^= 0x100000;
            }
        }
    });
    const inspect::DiffReport second = diff(traced.traces(), wrong);
    REQUIRE(second.difference);
    CHECK(second.difference->level == "pixel");
    CHECK(second.difference->region == 1);
    has(second, "(131, 70) of the picture");
    has(second, "blue is");
    has(second, " in B (bit 4)");
    has(second, "B is wrong: renderer-");
    has(second, "the pixel is #");
    has(second, "reference and fast of this program agree on the region");
    has(diff(wrong, traced.traces()), "A is wrong: renderer-");
    has(diff(wrong, wrong), "no difference");
}

TEST_CASE("pixels that only the host has are compared, too") {
    const test::TracedSphere traced({100, 100}, 1, 1);
    Traces a = traced.traces();
    for (inspect::NodeTrace& node : a) {
        std::erase_if(node.entries, [](const bus::trace::Entry& entry) {
            return entry.kind() == bus::Body::RegionPixels;
        });
    }
    Traces b = a;
    test::change<schema::FrameDone>(b, [](schema::FrameDoneT& done) { done.pixels[205] ^= 1; });
    CHECK_FALSE(diff(a, a).difference);
    has(diff(a, b), "(5, 2) of the picture");
    has(diff(a, b), "red is");
}

TEST_CASE("other counts of cycles are a difference") {
    const Traces a = test::TracedSphere({100, 100}, 1, 1).traces();
    Traces b = a;
    test::change<schema::RegionPixels>(b, [](schema::RegionPixelsT& pixels) {
        const schema::RegionTile& t = pixels.tiles[0];
        pixels.tiles[0] =
            schema::RegionTile(t.region(), t.has_depths(), t.cycles() + 1, t.instructions());
    });
    has(diff(a, b), "modelled cycles in A");
}

TEST_CASE("one voxel that differs is found, whoever holds it") {
    const auto forget_digest = [](Traces traces) {
        test::change<schema::VolumeHeader>(
            traces, [](schema::VolumeHeaderT& header) { header.digest = 0; });
        return traces;
    };
    const Traces a = forget_digest(test::TracedSphere({100, 100}, 3, 1).traces());
    Traces b = forget_digest(test::TracedSphere({100, 100}, 1, 1).traces());
    CHECK_FALSE(diff(a, b).difference);
    test::change<schema::Slices>(b, [](schema::SlicesT& slices) {
        if (slices.first_slice <= 1 && slices.first_slice + slices.slice_count > 1) {
            slices.values.at((1 - slices.first_slice) * slices.values.size() /
                             slices.slice_count) ^= 1;
        }
    });
    has(diff(a, b), "frame 0, Slices: voxel (0, 0, 1) is ");
}

TEST_CASE("equal machines that share the work otherwise are noted, and do not differ") {
    const Traces a = test::TracedSphere({200, 150}, 2, 2).traces();
    Traces b = a;
    test::change<schema::DrawFrame>(b, [](schema::DrawFrameT& draw) {
        draw.region_costs = {4, 3, 2, 1};
    });
    const inspect::DiffReport report = diff(a, b);
    CHECK_FALSE(report.difference);
    has(report, "note: equal results, but message ");
    has(report, "from host to gp-0 differs: DrawFrame in A, DrawFrame in B");
}

TEST_CASE("runs without a frame in common cannot be compared") {
    const Traces a = two_frames(1, 1);
    Traces b = a;
    inspect::DiffOptions none;
    none.selection.frames = {{7, 9}};
    CHECK_THROWS_AS(inspect::diff_runs(inspect::RecordedRun(a), inspect::RecordedRun(b), none),
                    host::RequestError);
}

TEST_CASE("of executors that part on a recorded run, the instruction is named with its cell") {
    const test::TracedSphere traced({200, 150}, 2, 2);
    const inspect::RecordedRun run = traced.run();
    CHECK_FALSE(inspect::diff_executors(run).difference);
    inspect::DiffOptions options;
    options.other = {"wrong", test::wrong_ahead_maker(1)};
    const inspect::DiffReport report = inspect::diff_executors(run, options);
    REQUIRE(report.difference);
    CHECK(report.difference->level == "instruction");
    has(report, "reference and wrong differ");
    has(report, "10 from gp-");
    has(report, "cell (");
    has(report, "z, bit 3 (m[11])");
}
