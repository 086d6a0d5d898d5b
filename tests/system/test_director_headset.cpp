// The director's pairs of pictures for a headset, and the pictures of the others meanwhile.
#include <doctest/doctest.h>

#include <string>
#include <utility>
#include <vector>

#include "tests/host/serve/headset_words.hpp"
#include "tests/system/theatre.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using namespace pxpl5::host::serve;
using namespace pxpl5::test;

namespace {

const Json off = {{"id", 99}, {"eyes", nullptr}};

/// A director before a viewer who puts on a headset.
struct HeadsetTheatre : Theatre {
    Eyes eyes(double azimuth_deg) {
        return eyes_at(director.session().frames.subject(), azimuth_deg);
    }
    void looks(int id, int pose, double azimuth_deg = 20) {
        watchers.says(eyes_message(id, pose, eyes(azimuth_deg)));
    }
    /// The picture that a fresh machine draws of the same scene.
    Picture alone(double azimuth_deg, Size size = {96, 80}) {
        Theatre fresh;
        fresh.director.session().scene = director.session().scene;
        return fresh.director.session().frames.draw_pair(eyes(azimuth_deg), {size, 0});
    }
    /// The frames since the last call: "pair 3, moving", and "1", "4", "16" for the samples of a
    /// resting picture.
    std::string shown() {
        std::string kinds;
        for (const serve::Shown& frame : watchers.frames) {
            kinds += kinds.empty() ? "" : ", ";
            kinds += frame.viewer != 0 ? "pair " + std::to_string(frame.pose)
                     : frame.rests     ? std::to_string(frame.samples)
                                       : "moving";
        }
        watchers.frames.clear();
        return kinds;
    }
    std::string error(int id) const {
        const Json reply = watchers.reply(id);
        return reply.is_object() && reply["ok"] == false ? reply["error"].get<std::string>() : "";
    }
};

}  // namespace

TEST_CASE("a pair is drawn for the newest eyes, with depths, for their viewer alone") {
    HeadsetTheatre stage;
    stage.watchers.frames.clear();
    stage.looks(1, 1, 10);
    stage.looks(2, 2, 20);
    stage.steps();
    CHECK(stage.watchers.reply(1) == Json{{"re", 1}, {"ok", true}, {"superseded", true}});
    CHECK(stage.watchers.reply(2) == Json{{"re", 2}, {"ok", true}});
    REQUIRE(stage.watchers.frames.size() == 1);
    const serve::Shown pair = stage.watchers.frames[0];
    CHECK(pair.viewer == 1);
    CHECK(pair.pose == 2);
    CHECK(pair.views == 2);
    CHECK(pair.width == 96);
    CHECK(pair.height == 80);
    CHECK(!pair.rests);
    CHECK(!pair.last);
    CHECK(pair.digest == 0);
    CHECK(pair.revision == stage.watchers.last("state")["revision"]);
    CHECK(stage.watchers.wearers.back() == std::pair<std::uint32_t, std::size_t>(1, 2 * 96 * 80));
    const Picture alone = stage.alone(20);
    CHECK(pair.pixels == alone.rgba);
    CHECK(pair.depths == alone.depths);
    stage.settle();
    CHECK(stage.watchers.frames.size() == 1);  // No other viewer looks, and nothing has changed.
}

TEST_CASE("a pair waits until its viewer has room for it, and the newest eyes are drawn then") {
    HeadsetTheatre stage;
    stage.watchers.frames.clear();
    stage.watchers.takes_pairs = false;
    stage.looks(1, 1, 10);
    stage.looks(2, 2, 20);
    stage.settle();
    CHECK(stage.watchers.frames.empty());
    CHECK(stage.watchers.reply(2).is_null());
    stage.watchers.takes_pairs = true;
    stage.settle();
    CHECK(stage.shown() == "pair 2");
    CHECK(stage.watchers.reply(2)["ok"] == true);
}

TEST_CASE("the pair follows the surfaces, the clip planes and the volume, with the same pose") {
    HeadsetTheatre stage;
    stage.looks(1, 7);
    stage.settle();
    std::uint32_t revision = stage.watchers.frames.back().revision;
    SharedWords pixels = stage.watchers.frames.back().pixels;
    stage.watchers.frames.clear();
    int id = 10;
    for (const char* line : {"surface sphere iso=0.25", "clip L 1", "background white", "undo",
                             "load phantom:torus"}) {
        CAPTURE(std::string(line));
        stage.watchers.does(++id, line);
        stage.settle();
        REQUIRE(stage.watchers.reply(id)["ok"] == true);
        REQUIRE(!stage.watchers.frames.empty());
        const serve::Shown pair = stage.watchers.frames.back();
        CHECK(stage.shown() == "pair 7");
        CHECK(pair.revision > revision);
        CHECK(pair.pixels != pixels);
        revision = pair.revision;
        pixels = pair.pixels;
    }
    stage.watchers.does(++id, "stats");
    stage.settle();
    CHECK(stage.shown() == "");
}

TEST_CASE("while others look, their pictures and the pairs take turns, and both go on") {
    HeadsetTheatre stage;
    stage.watchers.joins(2);
    stage.settle();
    stage.watchers.frames.clear();
    int id = 0, pose = 0;
    for (const char* color : {"white", "gray", "white"}) {
        stage.watchers.does(++id, std::string("background ") + color);
        stage.looks(++id, ++pose);
        stage.passes(goal_ms);
        stage.steps();
    }
    // The new pose does not wait for the command, whose change is drawn for both.
    CHECK(stage.shown() ==
          "pair 1, moving, pair 1, pair 2, moving, pair 2, pair 3, moving, pair 3");
    // A pose comes after each pair: the resting picture comes in spite of it, no refinement does.
    stage.watchers.on_show = [&](const serve::Shown& frame) {
        if (frame.viewer != 0 && pose < 8) {
            stage.passes(goal_ms);
            stage.looks(++id, ++pose);
        }
    };
    stage.passes(rest_ms);
    stage.looks(++id, ++pose);
    stage.steps();
    CHECK(stage.shown() == "1, pair 4, pair 5, pair 6, pair 7, pair 8");
    stage.settle();  // The head rests.
    CHECK(stage.shown() == "4, 16");
}

TEST_CASE("a new pose cancels a refinement") {
    HeadsetTheatre stage;
    stage.watchers.joins(2);
    stage.looks(1, 1);
    stage.settle();
    stage.watchers.frames.clear();
    stage.watchers.does(2, "background white");
    stage.watchers.on_show = [&](const serve::Shown& frame) {
        if (frame.rests && frame.samples == 4 && !stage.watchers.reply(3).is_object()) {
            stage.looks(3, 2);
        }
    };
    stage.settle();
    CHECK(stage.shown() == "moving, pair 1, 1, 4, pair 2, 16");
}

TEST_CASE("a flood of commands does not stop the pairs") {
    HeadsetTheatre stage;
    stage.watchers.frames.clear();
    stage.looks(1, 1);
    for (int i = 0; i < 40; ++i) {
        stage.watchers.does(10 + i, "pick 1 1");
    }
    for (int i = 0; i < 20; ++i) {
        stage.passes(10);
        stage.director.step();
        if (i == 10) {
            stage.looks(2, 2);
        }
    }
    CHECK(stage.shown() == "pair 1, pair 2");
    CHECK(stage.watchers.reply(45).is_null());  // The flood is not over.
}

TEST_CASE("the headset ends by null and with its viewer, and the state's picture comes back") {
    for (const bool leaves : {false, true}) {
        HeadsetTheatre stage;
        stage.watchers.joins(2);
        stage.looks(1, 1);
        stage.settle();
        stage.watchers.takes_pairs = false;
        stage.looks(2, 2);
        stage.steps();
        if (leaves) {
            stage.watchers.events.emplace_back(Left{1});
        } else {
            stage.watchers.says(off);
        }
        stage.steps();
        CHECK(stage.watchers.wearers.back().first == 0);
        CHECK(stage.watchers.reply(2)["superseded"] == true);
        CHECK((leaves || stage.watchers.reply(99) == Json{{"re", 99}, {"ok", true}}));
        stage.watchers.takes_pairs = true;
        stage.watchers.frames.clear();
        stage.watchers.says({{"id", 3}, {"do", "background white"}}, Role::driver, 2);
        stage.settle();
        CHECK(stage.shown() == "moving, 1, 4, 16");
        stage.watchers.says(eyes_message(4, 1, stage.eyes(5)), Role::driver, 2);
        stage.settle();
        CHECK(stage.watchers.reply(4) == Json{{"re", 4}, {"ok", true}});
        CHECK(stage.shown() == "pair 1");
    }
}

TEST_CASE("a lone viewer gets the resting picture when the headset is taken off") {
    HeadsetTheatre stage;
    stage.looks(1, 1);
    stage.settle();
    stage.watchers.does(2, "background white");
    stage.settle();
    CHECK(stage.watchers.frames.back().pose == 1);
    stage.watchers.frames.clear();
    stage.passes(rest_ms);
    stage.watchers.says(off);
    stage.settle();
    CHECK(stage.shown() == "1, 4, 16");
}

TEST_CASE("one viewer at a time wears a headset, until it is silent") {
    HeadsetTheatre stage;
    stage.watchers.joins(2);
    stage.looks(1, 4);
    stage.steps();
    const auto other = [&](int id, int pose) {
        stage.watchers.says(eyes_message(id, pose, stage.eyes(5)), Role::driver, 2);
        stage.steps();
    };
    other(2, 1);
    CHECK(stage.error(2).starts_with("eyes: another viewer wears a headset"));
    stage.watchers.says({{"id", 3}, {"eyes", nullptr}}, Role::driver, 2);  // Ends nothing.
    stage.looks(4, 5);
    stage.steps();
    CHECK(stage.watchers.reply(3)["ok"] == true);
    CHECK(stage.watchers.reply(4)["ok"] == true);
    CHECK(stage.watchers.wearers.back().first == 1);
    stage.passes(4900);
    other(5, 1);
    CHECK(stage.error(5).starts_with("eyes: another viewer"));
    stage.passes(200);
    other(6, 1);
    CHECK(stage.watchers.reply(6)["ok"] == true);
    CHECK(stage.watchers.wearers.back().first == 2);
    stage.looks(7, 6);
    stage.steps();
    CHECK(stage.error(7).starts_with("eyes: another viewer"));
}

TEST_CASE("eyes that cannot be drawn for are refused with a sentence, and the pair before stays") {
    HeadsetTheatre stage;
    stage.looks(1, 3);
    stage.steps();
    stage.watchers.frames.clear();
    Json scaled = eyes_message(2, 4, stage.eyes(5));
    scaled["eyes"]["left"]["patient_to_eye"][0] = 2;
    stage.watchers.says(scaled);
    stage.looks(3, 3);
    stage.watchers.says(eyes_message(4, 4, stage.eyes(5)), Role::watcher, 2);
    stage.steps();
    CHECK(stage.error(2).starts_with("message: eyes.left.patient_to_eye: columns 0 and 0"));
    CHECK(stage.error(3) == "eyes: pose 3 is not newer than pose 3");
    CHECK(stage.error(4) == "you only watch: a headset needs the address for drivers");
    CHECK(stage.watchers.frames.empty());
    stage.looks(5, 4);
    stage.steps();
    CHECK(stage.watchers.reply(5)["ok"] == true);
    CHECK(stage.shown() == "pair 4");
}

TEST_CASE("without a volume no pair is drawn, and with the next one the eyes are drawn again") {
    HeadsetTheatre stage;
    stage.watchers.does(1, "load phantom:sphere");
    stage.director.session().load_settings.progress = [&](const LoadProgress&) {
        stage.watchers.says({{"cancel", true}});
    };
    stage.watchers.does(2, "load phantom:pelvis");
    stage.settle();
    REQUIRE(stage.watchers.last("state")["volume"].is_null());
    stage.director.session().load_settings.progress = {};
    stage.watchers.frames.clear();
    stage.watchers.says(eyes_message(3, 1, eyes_at({}, 5)));
    stage.settle();
    CHECK(stage.error(3) == "eyes: no volume is open. Open a volume first");
    stage.watchers.does(4, "load phantom:sphere");
    stage.settle();
    CHECK(stage.shown() == "pair 1");
}

TEST_CASE("a machine that dies while it draws a pair, or before, is started again for the pair") {
    HeadsetTheatre stage;
    stage.looks(1, 1);
    stage.settle();
    const SharedWords before = stage.watchers.frames.back().pixels;
    stage.watchers.frames.clear();
    stage.dies = true;
    stage.looks(2, 2);
    stage.settle();
    CHECK(stage.launches == 2);
    CHECK(stage.watchers.reply(2)["ok"] == true);
    REQUIRE(stage.watchers.frames.size() == 1);
    CHECK(stage.watchers.frames[0].pose == 2);
    CHECK(stage.watchers.frames[0].pixels == before);
    stage.watchers.frames.clear();
    stage.dies = true;
    stage.watchers.does(3, "digest");
    stage.settle();
    CHECK(stage.launches == 3);
    REQUIRE(stage.watchers.frames.size() == 1);  // The frames under way were lost.
    CHECK(stage.watchers.frames[0].pose == 2);
    CHECK(stage.watchers.frames[0].pixels == before);
}

TEST_CASE(
    "eyes that arrive while a pair is drawn come next, also after the headset was taken off") {
    HeadsetTheatre stage;
    stage.watchers.frames.clear();
    stage.during = [&] { stage.looks(2, 2); };
    stage.looks(1, 1);
    stage.steps();
    CHECK(stage.watchers.reply(1) == Json{{"re", 1}, {"ok", true}});  // It was drawn.
    CHECK(stage.watchers.reply(2) == Json{{"re", 2}, {"ok", true}});
    CHECK(stage.shown() == "pair 1, pair 2");
    stage.during = [&] { stage.watchers.says(off); };
    stage.looks(3, 3);
    stage.settle();
    CHECK(stage.watchers.reply(3)["ok"] == true);
    stage.looks(4, 1);  // A new headset, whose poses count from 1 again.
    stage.settle();
    CHECK(stage.watchers.reply(4) == Json{{"re", 4}, {"ok", true}});
}

TEST_CASE("pairs get smaller while they take too long, and by the advice of the server") {
    HeadsetTheatre stage;
    stage.watchers.frames.clear();
    for (int pose = 1; pose <= 3; ++pose) {
        stage.during = [&] { stage.passes(2 * goal_ms); };
        stage.watchers.says(eyes_message(pose, pose, stage.eyes(20), 256, 200));
        stage.steps();
    }
    std::vector<std::pair<int, int>> sizes;
    for (const serve::Shown& frame : stage.watchers.frames) {
        sizes.emplace_back(frame.width, frame.height);
        CHECK(frame.pixels.size() == 2 * static_cast<std::size_t>(frame.width * frame.height));
    }
    CHECK(sizes == std::vector<std::pair<int, int>>{{256, 200}, {192, 150}, {128, 100}});
    CHECK(stage.watchers.frames.back().pixels == stage.alone(20, {128, 100}).rgba);

    HeadsetTheatre slow;
    slow.watchers.pair_scale = 0.75;
    slow.watchers.says(eyes_message(1, 1, slow.eyes(20), 256, 200));
    slow.steps();
    CHECK(slow.watchers.frames.back().width == 192);
}

TEST_CASE("a headset changes nothing of the scene, its history or the machine's pictures") {
    HeadsetTheatre stage;
    stage.watchers.does(1, "view 10 20");
    stage.settle();
    const Json state = stage.watchers.last("state");
    const std::uint64_t digest = stage.watchers.frames.back().digest;
    stage.looks(2, 1);
    stage.looks(3, 2, 120);
    stage.settle();
    stage.watchers.says(off);
    stage.watchers.does(4, "digest");
    stage.settle();
    CHECK(stage.watchers.last("state") == state);
    stage.watchers.does(5, "view 10 21");
    stage.settle();
    stage.watchers.does(6, "view 10 20");
    stage.settle();
    CHECK(stage.watchers.frames.back().digest == digest);
}
