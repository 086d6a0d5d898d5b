// The director when something goes wrong: commands that fail, loads given up, machines that die.
#include <doctest/doctest.h>

#include <string>
#include <system_error>
#include <vector>

#include "tests/system/theatre.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using namespace pxpl5::host::serve;
using namespace pxpl5::test;

TEST_CASE("after a load that was given up nothing leads back to the volume before") {
    Theatre stage;
    stage.watchers.does(1, "surface sphere iso=0.25");
    stage.settle();
    stage.director.session().load_settings.progress = [&](const LoadProgress&) {
        stage.watchers.says({{"cancel", true}});
    };
    stage.watchers.does(2, "load phantom:pelvis");
    stage.settle();
    REQUIRE(stage.watchers.reply(2)["error"] == "canceled");
    CHECK(stage.watchers.last("state")["undo"].is_null());
    stage.watchers.does(3, "undo");
    stage.settle();
    CHECK(stage.watchers.reply(3)["error"].get<std::string>().starts_with("there is nothing"));
    stage.dies = true;
    stage.watchers.does(4, "load phantom:sphere");
    stage.settle();
    CHECK(stage.launches == 2);
    CHECK(stage.watchers.last("state")["volume"].is_null());
}

TEST_CASE("an error of another kind is one command's, and the program goes on") {
    Theatre stage;
    stage.watchers.does(1, "load \"\"");
    stage.settle();
    CHECK(stage.watchers.reply(1)["error"] == "load: the name of the volume is empty");
    stage.director.session().load_settings.progress = [](const LoadProgress&) {
        throw std::system_error(std::make_error_code(std::errc::io_error), "a disk");
    };
    stage.watchers.does(2, "load phantom:pelvis");
    stage.settle();
    CHECK(stage.watchers.reply(2)["ok"] == false);
    CHECK(stage.watchers.reply(2)["error"].get<std::string>().starts_with("a disk"));
    stage.director.session().load_settings.progress = {};
    stage.watchers.does(3, "load phantom:pelvis");
    stage.settle();
    CHECK(stage.watchers.reply(3)["ok"] == true);
    CHECK(stage.launches == 1);
}

TEST_CASE("a machine that dies is started again, with everything as it was") {
    Theatre stage;
    stage.watchers.does(1, "view 30 20 roll=10");
    stage.watchers.does(2, "surface sphere iso=0.25 color=red");
    stage.watchers.does(3, "light 1 off");
    stage.settle();
    const std::uint64_t before = stage.watchers.frames.back().digest;
    stage.dies = true;
    stage.watchers.does(4, "digest");
    stage.settle();
    CHECK(stage.launches == 2);
    CHECK(stage.watchers.reply(4)["error"].get<std::string>().find("gp-1 was killed") !=
          std::string::npos);
    CHECK(stage.watchers.frames.back().digest == before);
    CHECK(stage.watchers.frames.back().rests);
    stage.watchers.does(5, "undo");
    stage.settle();
    CHECK(stage.watchers.reply(5)["ok"] == true);
    CHECK(stage.director.session().scene.lights.size() == 2);
}

TEST_CASE("the whole scene is put back after a death") {
    Theatre stage;
    const std::vector<std::string> lines = {"view 30 20 zoom=1.5 roll=10 pan=3,4",
                                            "surface sphere iso=0.25 color=red opacity=0.5",
                                            "light 1 off",
                                            "material ambient=0.3",
                                            "background white",
                                            "clip L 1",
                                            "tint gaps",
                                            "size 96x80",
                                            "antialias 4",
                                            "overlay on"};
    int id = 0;
    for (const std::string& line : lines) {
        stage.watchers.does(++id, line);
        stage.settle();
        CHECK_MESSAGE(stage.watchers.reply(id)["ok"] == true, line);
    }
    const Scene before = stage.director.session().scene;
    stage.dies = true;
    stage.watchers.does(100, "digest");
    stage.settle();
    REQUIRE(stage.launches == 2);
    const Scene& after = stage.director.session().scene;
    CHECK(same_parameters(before, after));
    // Does not compile when Scene has a member that this test does not know of.
    const auto& [camera, lights, material, background, size, surfaces, clips, tint_gaps, gap_colour,
                 samples, overlay] = after;
    CHECK(camera == before.camera);
    CHECK(lights == before.lights);
    CHECK(material == before.material);
    CHECK(background == before.background);
    CHECK(size == before.size);
    CHECK(surfaces.size() == before.surfaces.size());
    CHECK(clips == before.clips);
    CHECK(tint_gaps == before.tint_gaps);
    CHECK(gap_colour == before.gap_colour);
    CHECK(samples == before.samples);
    CHECK(overlay == before.overlay);
    CHECK(samples == 4);
}

TEST_CASE("a machine that cannot be started again at once is started once more") {
    Theatre stage;
    stage.watchers.does(1, "view 30 20");
    stage.settle();
    const std::uint64_t before = stage.watchers.frames.back().digest;
    stage.dies = true;
    stage.failing_launches = 1;
    stage.watchers.does(2, "digest");
    stage.settle();
    CHECK(stage.launches == 3);
    CHECK(stage.watchers.frames.back().digest == before);
    stage.watchers.does(3, "undo");
    stage.settle();
    CHECK(stage.watchers.reply(3)["ok"] == true);
}

TEST_CASE("a machine that cannot be started again ends the program with the launch's error") {
    Theatre stage;
    stage.dies = true;
    stage.failing_launches = max_deaths;
    stage.watchers.does(1, "digest");
    CHECK_THROWS_WITH_AS(stage.settle(), "no node can be started", MachineError);
    CHECK(stage.launches == max_deaths);
}

TEST_CASE("a machine that dies three times in a minute ends the program with its error") {
    Theatre stage;
    for (int i = 0; i < max_deaths - 1; ++i) {
        stage.dies = true;
        stage.watchers.does(i, "digest");
        stage.settle();
    }
    stage.dies = true;
    stage.watchers.does(9, "digest");
    CHECK_THROWS_WITH_AS(stage.settle(), "gp-1 was killed by signal 9 (SIGKILL)", MachineError);
}

TEST_CASE("deaths that are far apart do not end the program") {
    Theatre stage;
    for (int i = 0; i < max_deaths + 1; ++i) {
        stage.dies = true;
        stage.watchers.does(i, "digest");
        stage.settle();
        stage.passes(death_window_ms / (max_deaths - 1));
    }
    CHECK(stage.launches == max_deaths + 2);
}
