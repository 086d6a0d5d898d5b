// Pictures of two eyes, from one frame buffer or from two, as a session sees them.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <map>
#include <vector>

#include "host/base/error.hpp"
#include "host/commands/commands.hpp"
#include "tests/system/pictures/letters_bench.hpp"

using namespace pxpl5;
using namespace pxpl5::test;

TEST_CASE("each eye of a pair is the picture of its camera alone, bit for bit, on any machine") {
    LettersBench bench(2, 3);
    bench.session.scene.stereo = {StereoMode::side_by_side, 40, 0};
    const Picture pair = bench.session.frames.draw();
    REQUIRE(pair.width == 400);
    REQUIRE(pair.height == 150);
    REQUIRE(bench.asked.back().views.size() == 2);
    LettersBench one(1, 1);
    std::vector<Pixels> alone;
    for (const std::size_t eye : {0U, 1U}) {
        schema::DrawFrameT draw = bench.asked.back();
        draw.views.erase(draw.views.begin() + static_cast<std::ptrdiff_t>(1 - eye));
        draw.region_costs.clear();
        alone.push_back(one.alone(draw, static_cast<std::uint32_t>(eye)));
        REQUIRE(alone.back().size() == 200 * 150);
        std::size_t wrong = 0;
        for (std::size_t p = 0; p < alone.back().size(); ++p) {
            wrong += pair.rgba[p / 200 * 400 + eye * 200 + p % 200] == alone.back()[p] ? 0 : 1;
        }
        CHECK(wrong == 0);
    }
    CHECK(alone[0] != alone[1]);

    LettersBench other(1, 1);
    for (const StereoMode mode :
         {StereoMode::side_by_side, StereoMode::crossed, StereoMode::rows, StereoMode::anaglyph}) {
        bench.session.scene.stereo.mode = mode;
        other.session.scene.stereo = bench.session.scene.stereo;
        CHECK(other.session.frames.draw().rgba == bench.session.frames.draw().rgba);
    }
    bench.session.scene.stereo.mode = StereoMode::rows;
    const Picture rows = bench.session.frames.draw();
    for (const int y : {74, 75}) {
        const auto row = [y](const SharedWords& pixels) {
            return Pixels(pixels.begin() + y * 200, pixels.begin() + (y + 1) * 200);
        };
        CHECK(row(rows.rgba) == row(alone[static_cast<std::size_t>(y % 2)]));
    }
}

TEST_CASE("with a frame buffer for each eye, every kind of frame has the same bits as with one") {
    LettersBench one(2, 3), two(2, 3, 2);
    const std::vector<bus::NodeId> buffers = two.machine.frame_buffer_ids();
    REQUIRE(buffers.size() == 2);
    const auto check_pictures = [&](int samples) {
        const Pixels expected = one.session.frames.draw_samples(samples)->rgba.copy();
        CHECK(two.session.frames.draw_samples(samples)->rgba == expected);
        const FrameReport &a = one.session.frames.last(), &b = two.session.frames.last();
        CHECK(b.region_cycles == a.region_cycles);
        CHECK(b.instructions == a.instructions);
        CHECK(b.region_renderers == a.region_renderers);
    };
    check_pictures(1);
    check_pictures(4);
    CHECK(two.views_done == std::map<bus::NodeId, int>{{buffers[0], 5}});  // Frames of one view.
    for (const StereoMode mode : {StereoMode::side_by_side, StereoMode::anaglyph}) {
        one.session.scene.stereo.mode = two.session.scene.stereo.mode = mode;
        two.views_done.clear();
        check_pictures(1);
        check_pictures(4);
        CHECK(two.views_done == std::map<bus::NodeId, int>{{buffers[0], 5}, {buffers[1], 5}});
    }
    one.session.scene.stereo.mode = two.session.scene.stereo.mode = StereoMode::crossed;
    const auto hit = one.session.frames.pick(300, 75), same = two.session.frames.pick(300, 75);
    REQUIRE(hit.has_value());
    REQUIRE(same.has_value());
    CHECK(same->pick.p_mm == hit->pick.p_mm);
    CHECK(two.session.frames.draw_counted().front().views == 2);
}

TEST_CASE("overlapping frames of two frame buffers finish in order, whichever is ahead") {
    LettersBench one(1, 1);
    one.session.scene.stereo.mode = StereoMode::rows;
    std::vector<Pixels> expected;
    one.session.frames.orbit(6, [&](int, const Picture& picture, const Camera&) {
        expected.push_back(picture.rgba.copy());
    });
    int ahead = 0;
    for (std::uint64_t seed = 1; seed <= 8; ++seed) {
        CAPTURE(seed);
        // The frames whose parts have come to the host from one frame buffer only.
        std::map<std::uint32_t, int> parts;
        Topology topology = plan(2, 3, 2);
        topology.seed = seed;
        test::SimulatedMachine machine(topology, {}, [&](bus::NodeId, const bus::Message& message) {
            if (const auto* done = message.as<schema::FrameDone>()) {
                ++parts[done->frame()];
                ahead +=
                    std::ranges::count(parts, 1, &std::pair<const std::uint32_t, int>::second) > 1;
            }
        });
        Session session(machine);
        session.volumes.load("phantom:letters");
        session.scene = one.session.scene;
        const Surface& letters = one.session.scene.surfaces.front();
        session.scene.surfaces.clear();
        session.surfaces.set("letters", letters.isovalue, CaseRule::watertight, letters.color);
        std::size_t taken = 0;
        session.frames.orbit(6, [&](int, const Picture& picture, const Camera&) {
            CHECK(picture.rgba == expected.at(taken++));
        });
        CHECK(taken == 6);
    }
    CHECK(ahead > 0);  // Else no seed has tried what this test is about.
}

TEST_CASE("a .jps and an .mpo have the pictures of both eyes, whatever the mode") {
    LettersBench bench(2, 3, 2);
    Session& session = bench.session;
    const auto snapshot = [&](const std::string& file) {
        return run_command(session, parse_line("snapshot " + file + " overlay=off"));
    };
    for (const char* file : {"/tmp/pair.jps", "/tmp/pair.MPO"}) {
        CHECK_THROWS_WITH_AS(snapshot(file),
                             doctest::Contains("holds a picture for each eye, but stereo is off. "
                                               "Type `stereo sbs` first, or write a .png"),
                             RequestError);
    }
    CHECK(bench.machine.exported.empty());
    session.scene.stereo.mode = StereoMode::side_by_side;
    const Pixels pair = session.frames.draw().rgba.copy();
    const auto byte_at = [](const schema::ExportPictureT& picture, std::size_t pixel) {
        std::uint32_t rgba = 0;
        std::memcpy(&rgba, &picture.rgba.at(4 * pixel), sizeof rgba);
        return rgba;
    };
    for (const StereoMode mode : {StereoMode::anaglyph, StereoMode::rows, StereoMode::crossed}) {
        session.scene.stereo.mode = mode;
        const Reply jps = snapshot("/tmp/pair.jps"), mpo = snapshot("/tmp/pair.MPO");
        CHECK(session.scene.stereo.mode == mode);
        CHECK(jps.text.starts_with("wrote /tmp/pair.jps (400x150, "));
        CHECK(mpo.text.starts_with("wrote /tmp/pair.MPO (2 pictures of 200x150, "));
        const schema::ExportPictureT& two = bench.machine.exported.back();
        const schema::ExportPictureT& one = *(bench.machine.exported.end() - 2);
        CHECK(one.count == 1);
        CHECK(one.width == 400);
        CHECK(two.count == 2);
        REQUIRE(two.width == 200);
        REQUIRE(two.height == 150);
        std::size_t wrong = 0;
        for (std::size_t p = 0; p < pair.size(); ++p) {
            const std::size_t eye = p % 400 / 200, row = p / 400, column = p % 200;
            wrong += byte_at(one, row * 400 + (1 - eye) * 200 + column) == pair[p] ? 0 : 1;
            wrong += byte_at(two, (eye * 150 + row) * 200 + column) == pair[p] ? 0 : 1;
        }
        CHECK(wrong == 0);
        const auto separation = std::ranges::find_if(
            two.attributes, [](const auto& each) { return each->name == "separation_mm"; });
        REQUIRE(separation != two.attributes.end());
        CHECK(std::stod((*separation)->value) ==
              doctest::Approx(
                  eye_places(session.scene.stereo, session.scene.camera, session.frames.subject())
                      .separation_mm)
                  .epsilon(1e-5));
    }
}

TEST_CASE("marks lie over each eye's picture of a stereo file") {
    LettersBench bench(1, 1);
    Session& session = bench.session;
    session.scene.stereo.mode = StereoMode::anaglyph;
    for (const char* file : {"/tmp/pair.png", "/tmp/pair.mpo", "/tmp/pair.jps"}) {
        run_command(session, parse_line(std::string("snapshot ") + file));
    }
    const auto& pictures = bench.machine.exported;
    const std::size_t of_one = pictures.at(0).marks.size();
    REQUIRE(of_one > 0);
    CHECK(pictures.at(1).marks.size() == of_one);  // Drawn over each of both.
    CHECK(pictures.at(2).marks.size() == 2 * of_one);
}

TEST_CASE("a picture of two eyes has several samples a pixel, too") {
    LettersBench bench(2, 2);
    bench.session.scene.stereo.mode = StereoMode::side_by_side;
    const Pixels plain = bench.session.frames.draw().rgba.copy();
    REQUIRE(bench.session.frames.max_samples() >= 4);
    const Pixels fine = bench.session.frames.draw_samples(4)->rgba.copy();
    CHECK(fine.size() == plain.size());
    CHECK(fine != plain);
    LettersBench other(1, 3);
    other.session.scene.stereo = bench.session.scene.stereo;
    CHECK(other.session.frames.draw_samples(4)->rgba == fine);
}

TEST_CASE("both eyes see a picked point at its place") {
    LettersBench bench(2, 2);
    Scene& scene = bench.session.scene;
    scene.stereo = {StereoMode::side_by_side, 40, 0};
    const Subject subject = bench.session.frames.subject();
    const std::vector<CameraMatrices> eyes = cameras_of(scene, subject);
    int points = 0, again = 0;
    for (int y = 5; y < 150; y += 10) {
        for (int x = 5; x < 200; x += 10) {
            const auto left = bench.session.frames.pick(x, y);
            if (!left) {
                continue;
            }
            ++points;
            const glm::dvec4 clip =
                eyes[1].projection * eyes[1].patient_to_eye * glm::dvec4(left->pick.p_mm, 1);
            const auto column = static_cast<int>((clip.x / clip.w + 1) / 2 * 200);
            const double row = (1 - clip.y / clip.w) / 2 * 150;
            CHECK(row == doctest::Approx(y + 0.5).epsilon(1e-3));  // No parallax up or down.
            const auto right = column >= 0 && column < 200
                                   ? bench.session.frames.pick(200 + column, y)
                                   : std::nullopt;
            // The other eye may see another part in front, or the next pixel's point.
            again += right && glm::distance(right->pick.p_mm, left->pick.p_mm) < 2 ? 1 : 0;
        }
    }
    CHECK(points > 20);
    CHECK(again > points * 3 / 4);
}

namespace {

/// The half of a pair that one eye sees.
Pixels half(const SharedWords& pair, std::size_t eye) {
    const auto pixels = static_cast<std::ptrdiff_t>(pair.size() / 2);
    const auto begin = pair.begin() + static_cast<std::ptrdiff_t>(eye) * pixels;
    return {begin, begin + pixels};
}

/// Eyes that no stereo mode has: turned towards each other and rolled, with frusta that differ.
Eyes crooked_eyes(Session& session) {
    const std::vector<CameraMatrices> straight =
        cameras_of(session.scene, session.frames.subject());
    Eyes eyes{straight.front(), straight.front()};
    const glm::dvec3 up(0, 1, 0), ahead(0, 0, 1);
    eyes.left.patient_to_eye =
        glm::rotate(glm::translate(glm::dmat4(1), {31, 4, 0}), 0.1, up) * eyes.left.patient_to_eye;
    eyes.right.patient_to_eye =
        glm::rotate(glm::translate(glm::dmat4(1), {-31, 9, 12}), 0.2, ahead) *
        eyes.right.patient_to_eye;
    eyes.left.projection[2][0] = 0.17;
    eyes.right.projection[2][1] = -0.11;
    eyes.right.projection[0][0] *= 0.8;
    return eyes;
}

}  // namespace

TEST_CASE("each eye of given matrices is its picture alone, with depths, on any machine") {
    LettersBench bench(2, 3);
    const Eyes eyes = crooked_eyes(bench.session);
    const Frames::Moving how{{120, 90}, 0};
    const Scene before = bench.session.scene;
    const Picture pair = bench.session.frames.draw_pair(eyes, how);
    REQUIRE(pair.width == 120);
    REQUIRE(pair.height == 90);
    REQUIRE(pair.views == 2);
    REQUIRE(pair.rgba.size() == 2 * 120 * 90);
    REQUIRE(pair.depths.size() == pair.rgba.size());
    CHECK(bench.session.scene.size == before.size);
    CHECK(half(pair.rgba, 0) != half(pair.rgba, 1));
    CHECK(half(pair.depths, 0) != half(pair.depths, 1));

    LettersBench one(1, 1), lone(1, 1);
    for (const std::size_t eye : {0U, 1U}) {
        const CameraMatrices& own = eye == 0 ? eyes.left : eyes.right;
        const Picture twice = one.session.frames.draw_pair({own, own}, how);  // An eye for both.
        CHECK(half(twice.rgba, 0) == half(pair.rgba, eye));
        schema::DrawFrameT draw = bench.asked.back();
        draw.views.erase(draw.views.begin() + static_cast<std::ptrdiff_t>(1 - eye));
        draw.region_costs.clear();
        CHECK(lone.alone(draw, static_cast<std::uint32_t>(eye)) == half(pair.rgba, eye));
        std::size_t seen = 0;
        for (const std::uint32_t depth : half(pair.depths, eye)) {
            seen += (depth & 0xffU) == 0 ? 0 : 1;
        }
        CHECK(seen > 500);
        CHECK(seen < 120 * 90);
    }
    for (const auto [gps, renderers, frame_buffers] :
         {std::array{1, 1, 2}, std::array{3, 2, 1}, std::array{2, 5, 2}}) {
        LettersBench other(gps, renderers, frame_buffers);
        other.session.scene.stereo.mode = StereoMode::anaglyph;  // Has no part in a pair.
        other.session.scene.camera.zoom = 3;
        const Picture same = other.session.frames.draw_pair(eyes, how);
        CHECK(same.rgba == pair.rgba);
        CHECK(same.depths == pair.depths);
    }
}

TEST_CASE("pairs and pictures of the camera, one after the other, have the same bits as alone") {
    LettersBench bench(2, 3, 2), fresh(2, 3, 2);
    const Eyes eyes = crooked_eyes(bench.session);
    const Frames::Moving how{{120, 90}, 0};
    const Pixels plain = fresh.session.frames.draw().rgba.copy();
    const Pixels pair = bench.session.frames.draw_pair(eyes, how).rgba.copy();
    for (int turn = 0; turn < 2; ++turn) {
        CHECK(bench.session.frames.draw().rgba == plain);
        CHECK(bench.asked.back().region_costs.size() == (turn == 0 ? 0 : 4));
        CHECK(bench.session.frames.draw_pair(eyes, how).rgba == pair);
        CHECK(bench.asked.back().region_costs.size() == 2);
    }
    bench.session.frames.announce(Frames::Moving{{200, 150}, 0});
    bench.session.surfaces.set("letters", bench.session.scene.surfaces.front().isovalue + 1,
                               CaseRule::watertight, {200, 180, 160});
    REQUIRE(bench.session.frames.has_frame_ahead());
    const Pixels newer = bench.session.frames.draw_pair(eyes, how).rgba.copy();
    CHECK(!bench.session.frames.has_frame_ahead());
    CHECK(newer.size() == pair.size());
    CHECK(newer != pair);
    CHECK(bench.session.frames.draw().rgba.size() == plain.size());
}

TEST_CASE("stereo headset says where a headset is used, and changes nothing") {
    LettersBench bench(1, 1);
    bench.session.scene.stereo = {StereoMode::rows, 40, 0};
    for (const char* line : {"stereo headset", "stereo headset separation=30"}) {
        CHECK_THROWS_WITH_AS(run_command(bench.session, parse_line(line)),
                             doctest::Contains("press the headset button"), RequestError);
        CHECK(bench.session.scene.stereo == Stereo{StereoMode::rows, 40, 0});
    }
    CHECK_THROWS_WITH_AS(run_command(bench.session, parse_line("stereo headsets")),
                         doctest::Contains("headset"), RequestError);
}
