// Pictures of several samples per pixel, as a session sees them.
#include <doctest/doctest.h>

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "host/base/error.hpp"
#include "host/commands/commands.hpp"
#include "host/scene/sample_offsets.hpp"
#include "tests/mean_pixel.hpp"
#include "tests/system/pictures/letters_bench.hpp"

using namespace pxpl5;
using namespace pxpl5::test;

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
    LettersBench bench(2, 3);
    const Pixels plain = bench.session.frames.draw().rgba.copy();
    for (const int samples : {4, 16}) {
        CAPTURE(samples);
        bench.asked.clear();
        const auto picture = bench.session.frames.draw_samples(samples);
        REQUIRE(picture.has_value());
        const std::int64_t instructions = bench.session.frames.last().instructions;
        const std::vector<schema::DrawFrameT> asked = bench.asked;
        REQUIRE(std::ssize(asked) == samples);
        CHECK(picture->rgba != plain);

        LettersBench other(1, 1);
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
    LettersBench bench(1, 1);
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

TEST_CASE("a drawing that is canceled between two passes gives no picture, and the next is right") {
    LettersBench bench(2, 2);
    const Pixels plain = bench.session.frames.draw().rgba.copy();
    const Pixels fine = bench.session.frames.draw_samples(16)->rgba.copy();
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
    LettersBench bench(1, 2);
    Session& session = bench.session;
    const Pixels plain = session.frames.draw().rgba.copy();
    const auto pick = session.frames.pick(100, 75);
    REQUIRE(pick.has_value());
    run_command(session, parse_line("antialias 4"));
    const Pixels fine = session.frames.draw().rgba.copy();
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
    LettersBench bench(1, 2);
    CHECK(bench.session.frames.max_samples() == 16);
    bench.session.scene.size = {1450, 1450};  // 144 regions; room for 128 and 256.
    CHECK(bench.session.frames.max_samples() == 4);
    CHECK_THROWS_WITH_AS(bench.session.frames.draw_samples(16), doctest::Contains("room for 128"),
                         RequestError);
    bench.session.scene.size = {4096, 4096};
    CHECK(bench.session.frames.max_samples() == 1);
    CHECK(!bench.session.scene.part.has_value());
    bench.session.scene.size = {200, 150};
    CHECK(bench.session.frames.draw_samples(16).has_value());
}

TEST_CASE("a picture whose sums have no room is drawn in parts, and is the same picture") {
    // Without letters at the seams a misplaced part could not be seen.
    const auto drawn = [](int renderers, StereoMode stereo) {
        LettersBench bench(1, renderers);
        Scene& scene = bench.session.scene;
        scene.samples = 16;
        scene.stereo.mode = stereo;
        scene.size = stereo == StereoMode::off ? Size{1290, 1160} : Size{1000, 1160};
        CHECK((bench.session.frames.max_samples() == 16) == (renderers > 2));
        const Picture picture = bench.session.frames.draw();
        CHECK(scene.size == (stereo == StereoMode::off ? Size{1290, 1160} : Size{1000, 1160}));
        CHECK(!scene.part.has_value());
        return picture;
    };
    for (const StereoMode stereo : {StereoMode::off, StereoMode::side_by_side}) {
        // 11 x 10 regions of two views, or 8 x 10: room for 64, and for all.
        const Picture parts = drawn(1, stereo), whole = drawn(3, stereo);
        REQUIRE(parts.width == whole.width);
        REQUIRE(parts.height == whole.height);
        REQUIRE(parts.rgba.size() == whole.rgba.size());
        std::size_t different = 0, surface = 0;
        for (std::size_t at = 0; at < whole.rgba.size(); ++at) {
            different += parts.rgba[at] != whole.rgba[at] ? 1 : 0;
            surface += whole.rgba[at] != whole.rgba[0] ? 1 : 0;
        }
        CHECK(surface > whole.rgba.size() / 20);
        // GPs compute places in floats, so that a part may round a corner to another sixteenth.
        CHECK(different <= surface / 100);
    }
}

TEST_CASE("a picture with its own settings leaves the scene as it was, also after an error") {
    LettersBench bench(1, 2);
    Session& session = bench.session;
    const Scene before = session.scene;
    const auto is_unchanged = [&] {
        const Scene& now = session.scene;
        return now.size == before.size && now.samples == before.samples &&
               now.overlay == before.overlay && now.background == before.background &&
               now.stereo.mode == before.stereo.mode && !now.part.has_value();
    };
    const std::string file = "snapshot no/such/folder/a.png size=300x20 ";
    for (const std::string& line :
         {file + "samples=4 overlay=off ground=white", file + "samples=16 ground=transparent",
          file + "samples=5", file + "ground=none",
          std::string("snapshot a.exr ground=transparent")}) {
        CAPTURE(line);
        CHECK_THROWS_AS(run_command(session, parse_line(line)), RequestError);
        CHECK(is_unchanged());
    }
    session.scene.stereo.mode = StereoMode::anaglyph;
    CHECK_THROWS_WITH_AS(run_command(session, parse_line("snapshot a.png ground=transparent")),
                         doctest::Contains("not possible in an anaglyph"), RequestError);
    CHECK(session.scene.background == before.background);
}
