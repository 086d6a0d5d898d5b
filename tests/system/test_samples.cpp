// Pictures of several samples a pixel, and of two eyes, as a session sees them.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>
#include <glm/geometric.hpp>
#include <memory>
#include <set>
#include <vector>

#include "host/base/error.hpp"
#include "host/commands/commands.hpp"
#include "host/scene/sample_offsets.hpp"
#include "host/session/session.hpp"
#include "tests/mean_pixel.hpp"
#include "tests/system/simulated_machine.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
namespace schema = bus::schema;

namespace {

Topology plan(int gps, int renderers) {
    Topology topology;
    topology.gp.count = gps;
    topology.renderer.count = renderers;
    topology.frame_buffer.count = 1;
    topology.seed = 1;
    return topology;
}

using Pixels = std::vector<std::uint32_t>;
constexpr std::uint32_t opaque_black = 0xFF000000;

/// A machine that shows the letters, and notes what it is asked to draw.
struct Bench {
    Bench(int gps, int renderers)
        : machine(plan(gps, renderers), {},
                  [this](bus::NodeId, const bus::Message& message) {
                      if (const auto* draw = message.as<schema::DrawFrame>()) {
                          draw->UnPackTo(&asked.emplace_back());
                      }
                  }),
          session(machine) {
        session.volumes.load("phantom:letters");
        session.scene.size = {200, 150};
        session.scene.camera.angles = {30, 20};
        const Volume& volume = session.volumes.volume();
        session.surfaces.set("letters", (volume.minimum + volume.maximum) / 2, CaseRule::watertight,
                             {200, 180, 160});
    }

    /// The picture of one pass alone.
    Pixels alone(schema::DrawFrameT draw, std::uint32_t frame) {
        draw.frame = frame;
        draw.sample = 0;
        draw.samples = 1;
        draw.read_back = true;
        machine.send(machine.gp_ids().front(), bus::pack(draw));
        Pixels pixels;
        machine.pump(
            [&](const bus::Message& message) {
                if (const auto* done = message.as<schema::FrameDone>()) {
                    pixels.assign(done->pixels()->begin(), done->pixels()->end());
                }
            },
            [&] { return !pixels.empty(); });
        return pixels;
    }

    std::vector<schema::DrawFrameT> asked;
    test::SimulatedMachine machine;
    Session session;
};

}  // namespace

TEST_CASE("samples lie in all rows and columns of a pixel's grid, about its center") {
    CHECK(sample_offset({0, 1}) == glm::ivec2(0));
    for (const int samples : {4, 16}) {
        CAPTURE(samples);
        glm::ivec2 sum(0);
        std::set<int> rows, columns;
        for (int k = 0; k < samples; ++k) {
            const glm::ivec2 offset = sample_offset({k, samples});
            CHECK(std::max(std::abs(offset.x), std::abs(offset.y)) <= 8);
            columns.insert(offset.x);
            rows.insert(offset.y);
            sum += offset;
        }
        CHECK(sum == glm::ivec2(0));
        CHECK(std::ssize(rows) == samples);
        CHECK(std::ssize(columns) == samples);
    }
}

TEST_CASE("a picture of 4 or 16 samples is the mean of as many pictures, each moved a little") {
    Bench bench(2, 3);
    const Pixels plain = bench.session.frames.draw().rgba;
    for (const int samples : {4, 16}) {
        CAPTURE(samples);
        bench.asked.clear();
        const auto picture = bench.session.frames.draw_samples(samples);
        REQUIRE(picture.has_value());
        const std::int64_t instructions = bench.session.frames.last().instructions;
        const std::vector<schema::DrawFrameT> asked = bench.asked;
        REQUIRE(std::ssize(asked) == samples);
        CHECK(picture->rgba != plain);

        Bench other(1, 1);
        std::vector<Pixels> alone;
        for (const schema::DrawFrameT& draw : asked) {
            alone.push_back(other.alone(draw, static_cast<std::uint32_t>(alone.size())));
            CHECK(draw.region_costs == asked[0].region_costs);
        }
        std::size_t wrong = 0;
        for (std::size_t p = 0; p < picture->rgba.size(); ++p) {
            wrong += picture->rgba[p] == (opaque_black | test::mean_pixel(alone, p)) ? 0 : 1;
        }
        CHECK(wrong == 0);
        CHECK(std::set<Pixels>(alone.begin(), alone.end()).size() == alone.size());
        CHECK(instructions > samples * 6 * 10);  // Of all passes; 6 regions.
    }
}

TEST_CASE("a pass shows what lies at its offset: moving the samples moves the picture back") {
    Bench bench(1, 1);
    bench.session.frames.draw_samples(4);
    const schema::DrawFrameT& first = bench.asked.at(0);
    const schema::DrawFrameT& third = bench.asked.at(2);  // Opposite: (-2, -6) and (2, 6).
    const auto at = [](const schema::DrawFrameT& draw, int row) {
        // Of a point on the axis, at w = 1: what the matrix's third column moves it by.
        return -draw.views[0]->projection->m()->Get(static_cast<unsigned>(8 + row));
    };
    // To see what lies to the right, the picture goes to the left: 2 / 16 of a pixel of 200, with
    // 2 across clip space. Up is positive there.
    CHECK(at(third, 0) == doctest::Approx(-2.0 / 16 * 2 / 200));
    CHECK(at(third, 1) == doctest::Approx(6.0 / 16 * 2 / 150));
    CHECK(at(first, 0) == doctest::Approx(2.0 / 16 * 2 / 200));
    CHECK(at(first, 1) == doctest::Approx(-6.0 / 16 * 2 / 150));
}

TEST_CASE("who says no between two passes gets no picture, and the next is as ever") {
    Bench bench(2, 2);
    const Pixels plain = bench.session.frames.draw().rgba;
    const Pixels fine = bench.session.frames.draw_samples(16)->rgba;
    for (const int asked_before : {0, 1, 3, 15}) {
        CAPTURE(asked_before);
        bench.asked.clear();
        int left = asked_before;
        CHECK_FALSE(bench.session.frames.draw_samples(16, [&] { return left-- > 0; }).has_value());
        CHECK(std::ssize(bench.asked) == asked_before);
        CHECK(bench.session.frames.draw().rgba == plain);
        CHECK(bench.session.frames.draw_samples(16, [] { return true; })->rgba == fine);
    }
}

TEST_CASE("antialias sets the samples of what is drawn, orbits too, but picks with one") {
    Bench bench(1, 2);
    Session& session = bench.session;
    const Pixels plain = session.frames.draw().rgba;
    const auto pick = session.frames.pick(100, 75);
    REQUIRE(pick.has_value());
    run_command(session, parse_line("antialias 4"));
    const Pixels fine = session.frames.draw().rgba;
    CHECK(fine == session.frames.draw_samples(4)->rgba);
    CHECK(fine != plain);
    const auto again = session.frames.pick(100, 75);
    REQUIRE(again.has_value());
    CHECK(again->pick.p_mm == pick->pick.p_mm);
    session.frames.orbit(2, [&](int index, const Picture& picture, const Camera&) {
        CHECK((picture.rgba == fine) == (index == 0));
    });
    CHECK_THROWS_WITH_AS(run_command(session, parse_line("antialias 5")),
                         "antialias: 5 samples per pixel, must be 1, 4, 16", RequestError);
    run_command(session, parse_line("antialias 1"));
    CHECK(session.frames.draw().rgba == plain);
}

TEST_CASE("the most samples are those that the Renderers have room to sum") {
    Bench bench(1, 2);
    CHECK(bench.session.frames.max_samples() == 16);
    bench.session.scene.size = {1450, 1450};  // 144 regions; room for 128 and 256.
    CHECK(bench.session.frames.max_samples() == 4);
    CHECK_THROWS_WITH_AS(bench.session.frames.draw_samples(16), doctest::Contains("room for 128"),
                         RequestError);
    bench.session.scene.size = {4096, 4096};
    CHECK(bench.session.frames.max_samples() == 1);
    bench.session.scene.size = {200, 150};
    CHECK(bench.session.frames.draw_samples(16).has_value());
}

TEST_CASE("each eye of a pair is the picture of its camera alone, bit for bit, on any machine") {
    Bench bench(2, 3);
    bench.session.scene.stereo = {StereoMode::side_by_side, 40, 0};
    const Picture pair = bench.session.frames.draw();
    REQUIRE(pair.width == 400);
    REQUIRE(pair.height == 150);
    REQUIRE(bench.asked.back().views.size() == 2);
    Bench one(1, 1);
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

    Bench other(1, 1);
    for (const StereoMode mode :
         {StereoMode::side_by_side, StereoMode::crossed, StereoMode::rows, StereoMode::anaglyph}) {
        bench.session.scene.stereo.mode = mode;
        other.session.scene.stereo = bench.session.scene.stereo;
        CHECK(other.session.frames.draw().rgba == bench.session.frames.draw().rgba);
    }
    bench.session.scene.stereo.mode = StereoMode::rows;
    const Picture rows = bench.session.frames.draw();
    for (const int y : {74, 75}) {
        const auto row = [y](const Pixels& pixels) {
            return Pixels(pixels.begin() + y * 200, pixels.begin() + (y + 1) * 200);
        };
        CHECK(row(rows.rgba) == row(alone[static_cast<std::size_t>(y % 2)]));
    }
}

TEST_CASE("a picture of two eyes has several samples a pixel, too") {
    Bench bench(2, 2);
    bench.session.scene.stereo.mode = StereoMode::side_by_side;
    const Pixels plain = bench.session.frames.draw().rgba;
    REQUIRE(bench.session.frames.max_samples() >= 4);
    const Pixels fine = bench.session.frames.draw_samples(4)->rgba;
    CHECK(fine.size() == plain.size());
    CHECK(fine != plain);
    Bench other(1, 3);
    other.session.scene.stereo = bench.session.scene.stereo;
    CHECK(other.session.frames.draw_samples(4)->rgba == fine);
}

TEST_CASE("both eyes see a picked point at its place") {
    Bench bench(2, 2);
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
