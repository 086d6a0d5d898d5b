// The frames of the director while one surface is transparent or the link is slow: layers, sizes.
#include <doctest/doctest.h>

#include <array>
#include <string>
#include <vector>

#include "host/serve/encoding/encode.hpp"
#include "tests/host/serve/headset_words.hpp"
#include "tests/system/theatre.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using namespace pxpl5::host::serve;
using namespace pxpl5::test;

namespace {

using Words = std::vector<std::uint32_t>;

/// One half of the words of a frame with two layers.
Words layer(const SharedWords& words, int index) {
    const auto half = static_cast<std::ptrdiff_t>(words.size() / 2);
    return {words.begin() + index * half, words.begin() + (index + 1) * half};
}

}  // namespace

TEST_CASE("while the camera moves, the only transparent surface is a layer of its own") {
    Theatre stage;
    stage.watchers.wants_depths = true;
    int id = 0;
    const auto does = [&](const std::string& line) {
        stage.watchers.frames.clear();
        stage.watchers.does(++id, line);
        stage.settle();
        CAPTURE(stage.watchers.reply(id).dump());
        REQUIRE(stage.watchers.reply(id)["ok"] == true);
    };
    const auto drawn = [&] {
        return stage.director.session()
            .frames.draw_samples(1, {}, ReadBack::pixels_and_depths)
            .value();
    };
    does("clip P 0");  // The inner surface is seen as well.
    std::string transparent = stage.watchers.last("state")["surfaces"][0]["name"];
    std::uint32_t index = 1;
    SUBCASE("in front") {
        does("surface second iso=0.3");
    }
    SUBCASE("inside") {
        does("surface second iso=0.3");
        transparent = "second";
        index = 2;
    }
    SUBCASE("at the same place, first in the list") {
        does("surface second iso=" +
             stage.watchers.last("state")["surfaces"][0]["isovalue"].dump());
    }
    SUBCASE("at the same place, second in the list") {
        does("surface second iso=" +
             stage.watchers.last("state")["surfaces"][0]["isovalue"].dump());
        transparent = "second";
        index = 2;
    }
    does("surface " + transparent + " opacity=0.375");
    does("view 10 20");
    REQUIRE(stage.watchers.frames.size() == 4);  // The layers, then 1, 4 and 16 samples.
    const serve::Shown frame = stage.watchers.frames[0];
    for (std::size_t i = 1; i < 4; ++i) {
        CHECK(stage.watchers.frames[i].rests);
        CHECK(stage.watchers.frames[i].layers == 1);
        CHECK(stage.watchers.frames[i].revision == frame.revision);
    }
    CHECK(!frame.rests);
    CHECK(std::array{frame.width, frame.height, frame.layers, frame.opacity} ==
          std::array{128, 96, 2, 6});
    REQUIRE(frame.pixels.size() == 2 * 128 * 96);
    REQUIRE(frame.depths.size() == 2 * 128 * 96);
    does("surface " + transparent + " visible=no");
    const Picture behind = drawn();
    CHECK(layer(frame.pixels, 0) == behind.rgba);
    CHECK(layer(frame.depths, 0) == behind.depths);
    does("surface " + transparent + " visible=yes opacity=1");
    const Picture whole = drawn();
    CHECK(layer(frame.pixels, 1) == whole.rgba);
    Words shows = whole.depths.copy();
    for (std::uint32_t& word : shows) {
        word = (word & 0xffU) == index ? (word & ~0xffU) + 1 : 0;  // The first of its own picture.
    }
    CHECK(layer(frame.depths, 1) == shows);
}

TEST_CASE("a state at rest is drawn in layers once, and only if a viewer wants depths") {
    Theatre stage;
    const std::string name = stage.watchers.last("state")["surfaces"][0]["name"];
    stage.watchers.does(1, "surface " + name + " opacity=0.5");
    stage.settle();
    stage.watchers.frames.clear();
    stage.watchers.wants_depths = true;
    stage.settle();
    REQUIRE(stage.watchers.frames.size() == 1);
    CHECK(stage.watchers.frames[0].layers == 2);
    CHECK(!stage.watchers.frames[0].rests);
    stage.watchers.wants_depths = false;
    stage.settle();
    stage.watchers.wants_depths = true;
    stage.settle();
    CHECK(stage.watchers.frames.size() == 1);
    stage.watchers.does(2, "light 1 10 10");  // The camera stays: the page needs no warped picture.
    stage.steps();
    CHECK(stage.watchers.frames.back().layers == 1);
    stage.settle();
    stage.watchers.frames.clear();
    stage.watchers.wants_depths = false;
    stage.watchers.does(3, "view 10 20");
    stage.settle();
    for (const serve::Shown& frame : stage.watchers.frames) {
        CHECK(frame.layers == 1);
    }
}

TEST_CASE("the only transparent surface has no holes in a moving picture") {
    Theatre stage;
    int id = 0;
    const auto does = [&](const std::string& line) {
        stage.watchers.frames.clear();
        stage.watchers.does(++id, line);
        stage.settle();
        REQUIRE(stage.watchers.reply(id)["ok"] == true);
    };
    const auto drawn = [&] { return stage.director.session().frames.draw_samples(1).value(); };
    const std::string name = stage.watchers.last("state")["surfaces"][0]["name"];
    does("clip P 0");
    does("surface second iso=0.3 opacity=0.375");
    std::string line;
    SUBCASE("of a new isovalue, with viewers who want depths") {
        stage.watchers.wants_depths = true;
        line = "surface second iso=0.35";
    }
    SUBCASE("of a new isovalue, without such viewers") {
        line = "surface second iso=0.35";
    }
    SUBCASE("of the other surface") {
        line = "surface " + name + " iso=0.6";
    }
    SUBCASE("of another camera") {
        line = "view 10 20";
    }
    does(line);
    REQUIRE(!stage.watchers.frames.empty());
    const serve::Shown frame = stage.watchers.frames[0];
    CHECK(!frame.rests);
    CHECK(frame.layers == 1);
    CHECK(frame.depths.empty());
    does("surface second visible=no");
    Words layers = drawn().rgba.copy();
    does("surface second visible=yes opacity=1");
    const Picture whole = drawn();
    layers.insert(layers.end(), whole.rgba.begin(), whole.rgba.end());
    CHECK(frame.pixels == blended(layers, 1, 6));
}

TEST_CASE("with one transparent surface each eye has two layers, with more they are left out") {
    Theatre stage;
    const std::string name = stage.watchers.last("state")["surfaces"][0]["name"];
    int id = 0, pose = 0;
    const auto newest_after = [&](const std::vector<std::string>& lines) {
        for (const std::string& line : lines) {
            stage.watchers.does(++id, line);
            stage.settle();
            REQUIRE(stage.watchers.reply(id)["ok"] == true);
        }
        stage.watchers.frames.clear();
        stage.watchers.says(
            eyes_message(++id, ++pose, eyes_at(stage.director.session().frames.subject(), 20)));
        stage.settle();
        for (const serve::Shown& each : stage.watchers.frames) {
            if (each.pose == static_cast<std::uint32_t>(pose)) {
                return each;
            }
        }
        return serve::Shown{};
    };
    const serve::Shown opaque = newest_after({"surface second iso=0.3"});
    REQUIRE(opaque.layers == 1);
    const serve::Shown without = newest_after({"surface " + name + " visible=no"});
    const serve::Shown layered = newest_after({"surface " + name + " visible=yes opacity=0.375"});
    CHECK(layered.views == 2);
    CHECK(layered.layers == 2);
    CHECK(layered.opacity == 6);
    const auto eye = static_cast<std::ptrdiff_t>(layered.pixels.size() / 4);
    REQUIRE(opaque.pixels.size() == static_cast<std::size_t>(2 * eye));
    REQUIRE(layered.depths.size() == layered.pixels.size());
    CHECK(opaque.pixels != without.pixels);
    const auto part = [eye](const serve::Shown& frame, int index) {
        return std::vector(frame.pixels.begin() + index * eye,
                           frame.pixels.begin() + (index + 1) * eye);
    };
    for (const int index : {0, 1}) {
        CHECK(part(layered, 2 * index) == part(without, index));
        CHECK(part(layered, 2 * index + 1) == part(opaque, index));
    }
    const serve::Shown third = newest_after({"surface third iso=0.5"});
    const serve::Shown both = newest_after({"surface second opacity=0.5"});
    CHECK(both.layers == 1);
    const serve::Shown alone =
        newest_after({"surface " + name + " visible=no", "surface second visible=no"});
    CHECK(both.pixels == alone.pixels);
    CHECK(both.pixels != third.pixels);
}

TEST_CASE("on a slow link moving pictures are smaller, but not alternate rows") {
    Theatre stage;
    stage.watchers.scale = 0.5;
    const auto moving = [&](int id, const std::string& line) {
        stage.watchers.frames.clear();
        stage.watchers.does(id, line);
        stage.settle();
        REQUIRE(!stage.watchers.frames.empty());
        REQUIRE(!stage.watchers.frames[0].rests);
        CHECK(stage.watchers.frames.back().scale == 1);
        return stage.watchers.frames[0];
    };
    const serve::Shown beside = moving(1, "stereo sbs");
    CHECK(beside.width == 2 * 64);
    CHECK(beside.scale == 0.5);
    CHECK_FALSE(beside.fixed_size);
    const serve::Shown rows = moving(2, "stereo rows");
    CHECK(rows.width == 128);
    CHECK(rows.scale == 1);
    CHECK(rows.fixed_size);
}
