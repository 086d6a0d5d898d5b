// The director on a simulated machine, before viewers whose every word and clock tick is the
// test's.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "host/commands/text/picture_text.hpp"
#include "tests/system/theatre.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using namespace pxpl5::host::serve;
using namespace pxpl5::test;

namespace {

/// From frame `first` on there is the picture itself, better twice, and no more.
void check_refined(const std::vector<serve::Shown>& frames, std::size_t first) {
    REQUIRE(frames.size() == first + 3);
    for (std::size_t i = 0; i < 3; ++i) {
        const serve::Shown& frame = frames[first + i];
        CHECK(frame.rests);
        CHECK(frame.samples == std::array{1, 4, 16}[i]);
        CHECK(frame.last == (i == 2));
    }
}

}  // namespace

TEST_CASE("a viewer that joins is greeted, and hears of the volume and its first surface") {
    Theatre stage;
    CHECK(stage.watchers.last("hello")["role"] == "driver");
    const Json commands = stage.watchers.last("hello")["commands"];
    CHECK(commands.size() == command_table().size());
    const auto surface = std::ranges::find_if(
        commands, [](const Json& command) { return command["name"] == "surface"; });
    REQUIRE(surface != commands.end());
    CHECK((*surface)["kind"] == "setting");
    CHECK((*surface)["subject_words"] == 1);
    const Json state = stage.watchers.last("state");
    CHECK(state["volume"]["name"] == "phantom:sphere");
    CHECK(state["surfaces"].size() == 1);
    CHECK(state["camera"]["patient_to_clip"].size() == 16);
    CHECK(state["busy"].is_null());
    CHECK(state["undo"].is_null());  // Its first surface is no step back to nothing.
    CHECK(state["redo"].is_null());
    CHECK(state["size"] == Json({128, 96}));
}

TEST_CASE("a flood of isovalues costs few extractions, and the newest is what rests") {
    Theatre stage;
    const int before = stage.extractions;
    for (int i = 1; i <= 1000; ++i) {
        stage.watchers.does(i, "surface sphere iso=" + std::to_string(0.001 * i - 0.6));
        if (i % 100 == 0) {
            stage.director.step();
        }
    }
    stage.steps();
    CHECK(stage.extractions - before <= 10);
    CHECK(stage.watchers.reply(50)["superseded"] == true);
    const Json newest = stage.watchers.reply(1000);
    CHECK(newest["ok"] == true);
    CHECK(newest["result"]["isovalue"].get<double>() == doctest::Approx(0.4));
    const serve::Shown moving = stage.watchers.frames.back();
    CHECK(!moving.rests);
    CHECK(moving.revision == newest["revision"]);
    stage.settle();
    const serve::Shown resting = stage.watchers.frames.back();
    CHECK(resting.rests);
    CHECK(resting.revision == newest["revision"]);
    CHECK(resting.samples == 16);
    CHECK(resting.digest == picture_digest(*stage.director.session().frames.draw_samples(16)));
    CHECK(stage.watchers.last("state")["revision"] == newest["revision"]);
    CHECK(stage.director.due_ms() < 0);  // No work is left, so the loop sleeps.
}

TEST_CASE("what moves is drawn at once, and itself 150 ms after the last input") {
    Theatre stage;
    stage.watchers.frames.clear();
    stage.watchers.does(1, "view 10 20");
    stage.steps();
    REQUIRE(stage.watchers.frames.size() == 1);
    CHECK(!stage.watchers.frames[0].rests);
    stage.passes(rest_ms - 10);
    stage.steps();
    CHECK(stage.watchers.frames.size() == 1);
    stage.watchers.does(2, "view 10 30");
    stage.steps();
    CHECK(stage.watchers.frames.size() == 2);
    stage.passes(rest_ms - 10);
    stage.steps();
    CHECK(stage.watchers.frames.size() == 2);
    stage.passes(11);
    stage.steps();
    check_refined(stage.watchers.frames, 2);
}

TEST_CASE("with detail auto, moving pictures are simplified and resting ones are exact") {
    Theatre stage;
    stage.director.session().load_settings.slabs_per_set = 16;
    stage.director.open("load phantom:sphere");
    stage.director.show_first_surfaces();
    stage.settle();
    const std::uint64_t exact = picture_digest(*stage.director.session().frames.draw_samples(16));
    stage.watchers.frames.clear();
    stage.watchers.does(1, "detail auto");
    stage.steps();
    CHECK(stage.watchers.last("state")["detail"] == "auto");
    REQUIRE(!stage.watchers.frames.empty());
    CHECK(!stage.watchers.frames.back().rests);
    CHECK(stage.watchers.frames.back().moved_mm > 0);
    stage.settle();
    CHECK(stage.watchers.frames.back().rests);
    CHECK(stage.watchers.frames.back().moved_mm == 0);
    CHECK(stage.watchers.frames.back().digest == exact);
    stage.watchers.does(2, "surface sphere iso=0.05");  // Its frame is requested ahead.
    stage.steps();
    CHECK(stage.watchers.frames.back().moved_mm > 0);
    stage.watchers.does(3, "detail 3");  // All pictures.
    stage.settle();
    CHECK(stage.watchers.frames.back().rests);
    CHECK(stage.watchers.frames.back().moved_mm > 0);
    stage.watchers.does(4, "detail exact");
    stage.steps();
    CHECK(stage.watchers.frames.back().moved_mm == 0);
}

TEST_CASE("frames of opaque surfaces have depths while a viewer asks for them") {
    Theatre stage;
    const auto& frames = stage.watchers.frames;
    const std::string name = stage.watchers.last("state")["surfaces"][0]["name"];
    int id = 0;
    const auto have_depths = [&](const std::string& line) {
        stage.watchers.frames.clear();
        stage.watchers.does(++id, line);
        stage.settle();
        CAPTURE(stage.watchers.reply(id).dump());
        CHECK(stage.watchers.reply(id)["ok"] == true);
        std::string found;
        for (const serve::Shown& frame : frames) {
            const bool fits = !frame.depths.empty() && frame.depths.size() == frame.pixels.size();
            found += fits ? 'd' : !frame.depths.empty() ? '?' : '-';
        }
        return found;
    };
    CHECK(have_depths("view 10 20") == "----");  // Moving, then 1, 4 and 16 samples.
    const std::uint64_t digest = frames.back().digest;
    const std::uint64_t first_digest = frames[1].digest;
    have_depths("view 10 30");
    stage.watchers.wants_depths = true;
    CHECK(have_depths("view 10 20") == "dddd");
    CHECK(frames.back().digest == digest);
    CHECK(frames[1].digest == first_digest);
    const std::uint32_t middle = frames[1].depths[48 * 128 + 64];
    CHECK((middle & 0xffU) == 1);  // The sphere, in front of the middle of the volume.
    CHECK((middle >> 8U) < (1U << 23U));
    CHECK((frames[1].depths[0] & 0xffU) == 0);
    CHECK(frames[3].depths.data() == frames[1].depths.data());          // Not drawn again.
    CHECK(have_depths("surface " + name + " opacity=0.5") == "--d--");  // Layers of the state.
    CHECK(have_depths("surface " + name + " visible=no") == "dddd");
    CHECK(have_depths("surface " + name + " visible=yes") == "--d--");
    CHECK(have_depths("surface second iso=0.3") == "--d--");
    CHECK(have_depths("surface second opacity=0.5") == "----");  // Two transparent surfaces.
    CHECK(have_depths("view 11 20") == "----");
    CHECK(have_depths("remove second") == "--d--");
    CHECK(have_depths("surface " + name + " opacity=1") == "dddd");
}

TEST_CASE("viewers who take depths get pairs, and others the same as one picture") {
    Theatre stage;
    const auto& frames = stage.watchers.frames;
    const auto shows = [&](int id, const std::string& line) {
        stage.watchers.frames.clear();
        stage.watchers.does(id, line);
        stage.settle();
        REQUIRE(frames.size() == 4);  // Moving, then 1, 4 and 16 samples.
    };
    shows(1, "stereo sbs");
    const std::vector<serve::Shown> composed = frames;
    for (const serve::Shown& frame : composed) {
        CHECK((frame.views == 1 && frame.depths.empty() && !frame.as_one));
        CHECK(frame.width == 2 * 128);
    }
    shows(2, "stereo off");
    stage.watchers.wants_depths = true;
    shows(3, "stereo sbs");
    for (std::size_t k = 0; k < frames.size(); ++k) {
        CAPTURE(k);
        const serve::Shown& frame = frames[k];
        REQUIRE((frame.views == 2 && !frame.depths.empty() && frame.as_one));
        CHECK((frame.width == 128 && frame.height == composed[k].height));
        CHECK(frame.depths.size() == frame.pixels.size());
        const serve::OnePicture one = frame.as_one();
        CHECK((one.width == composed[k].width && one.height == composed[k].height));
        CHECK(one.pixels == composed[k].pixels);
        CHECK(frame.digest == composed[k].digest);
    }
    CHECK(frames[3].depths == frames[1].depths);
}

TEST_CASE("a resting picture is drawn again, once, when a viewer asks for its depths") {
    Theatre stage;
    stage.watchers.does(1, "view 10 20");
    stage.settle();
    const std::uint64_t digest = stage.watchers.frames.back().digest;
    stage.watchers.frames.clear();
    stage.watchers.wants_depths = true;
    stage.settle();
    REQUIRE(stage.watchers.frames.size() == 3);  // 1, 4 and 16 samples.
    for (const serve::Shown& frame : stage.watchers.frames) {
        CHECK(!frame.depths.empty());
    }
    CHECK(stage.watchers.frames.back().digest == digest);
    stage.watchers.wants_depths = false;
    stage.settle();
    stage.watchers.wants_depths = true;
    stage.settle();
    CHECK(stage.watchers.frames.size() == 3);
}

TEST_CASE("a refinement is given up when something comes, and its picture is not shown") {
    Theatre stage;
    stage.watchers.frames.clear();
    stage.watchers.on_show = [&](const serve::Shown& frame) {
        if (frame.rests && frame.samples == 4 && !stage.watchers.reply(2).is_object()) {
            stage.watchers.does(2, "view 10 30");
        }
    };
    stage.watchers.does(1, "view 10 20");
    stage.settle();
    std::vector<std::pair<std::uint32_t, int>> shown;  // Revision after the first, and samples.
    for (const serve::Shown& frame : stage.watchers.frames) {
        shown.emplace_back(frame.revision - stage.watchers.frames[0].revision,
                           frame.rests ? frame.samples : 0);
    }
    CHECK(shown == std::vector<std::pair<std::uint32_t, int>>{
                       {0, 0}, {0, 1}, {0, 4}, {1, 0}, {1, 1}, {1, 4}, {1, 16}});
}

TEST_CASE("scrolling through slices does not hold up the refined picture") {
    Theatre stage;
    stage.watchers.frames.clear();
    stage.watchers.does(1, "view 10 20");
    stage.steps();
    stage.passes(rest_ms + 1);
    stage.watchers.scrolls = true;
    constexpr int rounds = 10;
    for (int i = 0; i < rounds; ++i) {
        stage.director.step();
    }
    check_refined(stage.watchers.frames, 1);
    constexpr int passes = 1 + 4 + 16;  // Slices are answered between them, too.
    CHECK(stage.watchers.binaries.size() == rounds + passes);
}

TEST_CASE("of questions for bytes the newest of each kind is answered") {
    Theatre stage;
    stage.watchers.says({{"id", 1}, {"ask", "slice"}, {"axis", "x"}});
    stage.watchers.says({{"id", 2}, {"ask", "slice"}, {"axis", "y"}});
    for (const int id : {4, 5}) {
        stage.watchers.says({{"id", id}, {"ask", "slice"}, {"axis", "x"}, {"ahead", true}});
    }
    stage.watchers.says({{"id", 3}, {"ask", "slice"}, {"axis", "x"}});
    stage.settle();
    CHECK(stage.watchers.reply(1)["superseded"] == true);
    CHECK(stage.watchers.reply(4)["superseded"] == true);
    CHECK(stage.watchers.binaries == std::vector<std::string>{"3", "2", "5"});
}

TEST_CASE("viewers who take no frame get the resting one, and none of those between") {
    Theatre stage;
    stage.watchers.frames.clear();
    stage.watchers.takes_frames = false;
    for (int i = 0; i < 20; ++i) {
        stage.watchers.does(i, "view 10 " + std::to_string(i));
        stage.steps();
    }
    CHECK(stage.watchers.frames.empty());
    stage.settle();
    check_refined(stage.watchers.frames, 0);
}

TEST_CASE("a question changes no revision and draws nothing") {
    Theatre stage;
    const Json before = stage.watchers.last("state")["revision"];
    const std::size_t frames = stage.watchers.frames.size();
    stage.watchers.does(1, "stats");
    stage.settle();
    CHECK(stage.watchers.reply(1)["revision"] == before);
    CHECK(stage.watchers.frames.size() == frames);
}

TEST_CASE("a watcher changes nothing, and no page can end the program") {
    Theatre stage;
    stage.watchers.says({{"id", 1}, {"do", "view 10 20"}}, Role::watcher);
    stage.watchers.says({{"id", 2}, {"ask", "scrub"}}, Role::watcher);
    stage.watchers.does(3, "quit");
    stage.watchers.does(4, "surfice bone");
    stage.watchers.does(5, "surface bone");
    stage.settle();
    for (const int id : {1, 2, 3, 4, 5}) {
        CHECK(stage.watchers.reply(id)["ok"] == false);
        CHECK(!stage.watchers.reply(id)["error"].get<std::string>().empty());
    }
    CHECK(stage.director.session().scene.camera.angles.azimuth_deg == 0);
}

TEST_CASE("what is open is told when it changes, and not of a load that failed") {
    Theatre stage;
    int id = 0;
    for (const char* line : {"view 10 20", "load phantom:torus", "load phantom:nothing",
                             "load phantom:torus smooth=1", "load phantom:sphere"}) {
        stage.watchers.does(++id, line);
        stage.settle();
    }
    CHECK(stage.watchers.openings ==
          std::vector<std::string>{"phantom:sphere", "phantom:torus", "phantom:sphere"});
}

TEST_CASE("a load is given up when somebody says so, and leaves nothing") {
    Theatre stage;
    stage.watchers.does(1, "load phantom:pelvis");
    stage.watchers.does(2, "load phantom:pelvis");
    stage.director.step();  // Takes both, does the first.
    CHECK(stage.watchers.reply(1)["ok"] == true);
    CHECK(stage.watchers.last("progress").is_null());
    // The second is under way when the word comes: it waits where pump() looks.
    stage.director.session().load_settings.progress = [&](const LoadProgress&) {
        stage.watchers.says({{"cancel", true}});
    };
    stage.director.step();
    CHECK(stage.watchers.reply(2)["ok"] == false);
    CHECK(stage.watchers.reply(2)["error"] == "canceled");
    stage.settle();
    CHECK(stage.watchers.last("state")["volume"].is_null());
    CHECK(stage.watchers.last("state")["busy"].is_null());
}

TEST_CASE("a session without use is announced to end, goes on when used, and ends") {
    constexpr double minute_ms = 60'000;
    Theatre stage(10 * minute_ms);
    CHECK(stage.director.due_ms() <= 8 * minute_ms);
    stage.passes(7.9 * minute_ms);
    stage.watchers.says({{"id", 1}, {"ping", true}});  // The page's, without the user.
    stage.watchers.says({{"id", 2}, {"ask", "slice"}, {"axis", "x"}}, Role::watcher);
    stage.steps();
    CHECK(stage.watchers.last("state")["end"].is_null());
    stage.passes(0.2 * minute_ms);
    stage.steps();
    const Json end = stage.watchers.last("state")["end"];
    REQUIRE(end.is_object());
    CHECK(end["why"].get<std::string>().starts_with("it has not been used for some time"));
    CHECK(!end["at"].get<std::string>().empty());
    CHECK(!stage.director.is_idle_too_long());

    stage.watchers.does(3, "view 10 20");
    stage.steps();
    CHECK(stage.watchers.last("state")["end"].is_null());
    stage.passes(9.9 * minute_ms);
    CHECK(!stage.director.is_idle_too_long());
    stage.steps();
    CHECK(stage.watchers.last("state")["end"].is_object());
    stage.passes(0.2 * minute_ms);
    CHECK(stage.director.is_idle_too_long());
    CHECK(stage.director.due_ms() == 0);
    stage.director.run();  // Returns.
}

TEST_CASE("the time of a long command counts as use") {
    constexpr double minute_ms = 60'000;
    Theatre stage(10 * minute_ms);
    stage.director.session().load_settings.progress = [&](const LoadProgress&) {
        stage.passes(30 * minute_ms);
    };
    stage.watchers.does(1, "load phantom:torus");
    stage.steps();
    CHECK(stage.watchers.reply(1)["ok"] == true);
    CHECK(!stage.director.is_idle_too_long());
}

TEST_CASE("the announced end of a job stays announced while the session is used") {
    constexpr double minute_ms = 60'000;
    Theatre stage(10 * minute_ms);
    stage.passes(8.1 * minute_ms);
    stage.steps();
    stage.watchers.events.emplace_back(EndsSoon{1'000'000'000, "job 12 reaches its time limit"});
    stage.watchers.does(1, "view 10 20");
    stage.steps();
    CHECK(stage.watchers.last("state")["end"]["why"] == "job 12 reaches its time limit");
}
