// The director when something goes wrong: commands that fail, loads given up, machines that die.
#include <doctest/doctest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <system_error>
#include <vector>

#include "host/base/state_folder.hpp"
#include "tests/system/theatre.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using namespace pxpl5::host::serve;
using namespace pxpl5::test;

namespace {

constexpr int most_restarts = RestartSettings{}.max;

}  // namespace

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
    CHECK(stage.watchers.reply(4)["ok"] == true);  // The command ran again.
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
                                            "surface sphere rim=0.25",
                                            "light 1 off",
                                            "material ambient=0.3",
                                            "background white",
                                            "clip L 1",
                                            "planes z=9 x=4 window=3 level=1",
                                            "tint gaps",
                                            "size 96x80",
                                            "antialias 4",
                                            "detail auto",
                                            "stereo anaglyph separation=20",
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
    const auto& [camera, lights, material, background, size, part, frame, surfaces, clips, planes,
                 planes_window, tint_gaps, gap_color, samples, detail, stereo, overlay] = after;
    CHECK(camera == before.camera);
    CHECK(lights == before.lights);
    CHECK(material == before.material);
    CHECK(background == before.background);
    CHECK(size == before.size);
    CHECK_FALSE(part.has_value());
    CHECK(frame == before.frame);
    CHECK(surfaces.size() == before.surfaces.size());
    CHECK(surfaces.back().rim == 4);
    CHECK(clips == before.clips);
    CHECK(planes == before.planes);
    CHECK(planes_window == before.planes_window);
    CHECK(tint_gaps == before.tint_gaps);
    CHECK(gap_color == before.gap_color);
    CHECK(samples == before.samples);
    CHECK(detail == before.detail);
    CHECK(stereo == before.stereo);
    CHECK(overlay == before.overlay);
    CHECK(samples == 4);
    CHECK(stereo.mode == StereoMode::anaglyph);
    CHECK(detail.is_auto);
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
    stage.failing_launches = most_restarts;
    stage.watchers.does(1, "digest");
    CHECK_THROWS_WITH_AS(
        stage.settle(),
        "no node can be started. The machine was started again 3 times for this work; "
        "gp.restart.max is 3, and --set gp.restart.max=N changes this",
        MachineError);
    CHECK(stage.launches == 1 + most_restarts);
    CHECK(stage.watchers.reply(1)["ok"] == false);
}

TEST_CASE("the session of before the restarts is saved if none succeeds, and else is not kept") {
    const TemporaryFolder folder("pxpl5-saved-test");
    const std::filesystem::path saved = folder.path() / "saved" / "run.pxpl5";
    Theatre stage(0, saved);
    stage.watchers.does(1, "surface extra iso=300");
    stage.settle();
    stage.dies = true;
    stage.watchers.does(2, "digest");
    stage.settle();
    CHECK(stage.watchers.reply(2)["ok"] == true);
    CHECK_FALSE(std::filesystem::exists(saved));
    stage.dies = stage.dies_always = true;  // Also while the volume is given again.
    stage.watchers.does(3, "digest");
    CHECK_THROWS_AS(stage.settle(), MachineError);
    std::ifstream file(saved);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    CHECK_MESSAGE(text.find("\nsurface extra ") != std::string::npos, text);
}

TEST_CASE("a machine that dies of each attempt at a command ends the program with its error") {
    Theatre stage;
    stage.dies = stage.dies_always = true;
    stage.watchers.does(1, "digest");
    CHECK_THROWS_WITH_AS(stage.settle(),
                         "gp-1 was killed by signal 9 (SIGKILL). The machine was started again 3 "
                         "times for this work; gp.restart.max is 3, and --set "
                         "gp.restart.max=N changes this",
                         MachineError);
    CHECK(stage.launches == 1 + most_restarts);
}

TEST_CASE("one death in each of many commands does not end the program") {
    Theatre stage;
    for (int i = 0; i < most_restarts + 1; ++i) {
        stage.dies = true;
        stage.watchers.does(i, "digest");
        stage.settle();
        CHECK(stage.watchers.reply(i)["ok"] == true);
    }
    CHECK(stage.launches == 2 + most_restarts);
}

TEST_CASE("scale changes the nodes of the viewer's machine, and the picture stays") {
    Theatre stage;
    const std::uint64_t before = stage.watchers.frames.back().digest;
    stage.watchers.does(1, "scale gp=+3 renderer=1");
    stage.settle();
    REQUIRE(stage.watchers.reply(1)["ok"] == true);
    CHECK(stage.watchers.reply(1)["result"]["gps"] == 5);
    CHECK(stage.watchers.reply(1)["result"]["renderers"] == 1);
    CHECK(stage.director.session().conversation.gps().size() == 5);
    stage.watchers.does(2, "view 10 10");
    stage.settle();
    CHECK(stage.watchers.frames.back().digest != before);
    stage.watchers.does(3, "undo");
    stage.settle();
    CHECK(stage.watchers.frames.back().digest == before);
    stage.watchers.does(4, "scale gp=-5");
    stage.settle();
    CHECK(stage.watchers.reply(4)["error"] ==
          "scale: gp is '-5', which makes 0 of 5, must make 1..64");
    CHECK(stage.launches == 2);
}

TEST_CASE("a node can be killed while a short command waits for it, and the scene comes back") {
    Theatre stage;
    stage.during = [&] { stage.watchers.does(2, "kill gp-0"); };
    stage.watchers.does(1, "surface sphere iso=0.25");
    stage.director.step();
    CHECK(stage.watchers.reply(2)["ok"] == true);
    CHECK(stage.watchers.reply(1)["ok"] == true);
    CHECK(stage.launches == 2);
    stage.settle();
    CHECK(stage.watchers.last("state")["surfaces"].size() == 2);
    stage.during = [&] { stage.watchers.does(4, "kill gp-77"); };
    stage.watchers.does(3, "surface sphere iso=0.2");
    stage.settle();
    CHECK(stage.watchers.reply(3)["ok"] == true);
    CHECK(stage.watchers.reply(4)["ok"] == false);
    CHECK(stage.launches == 2);
}

TEST_CASE("a viewer who joins while a picture or a command waits for nodes is greeted at once") {
    Theatre stage;
    for (const char* line : {"surface sphere iso=0.25", "view 10 20"}) {
        bool is_greeted = false;
        stage.watchers.texts.clear();
        stage.during = [&] {
            stage.watchers.joins(7);
            stage.during = [&] {
                is_greeted = !stage.watchers.last("hello").is_null();
                CHECK(stage.watchers.last("state")["volume"]["name"] == "phantom:sphere");
            };
        };
        stage.watchers.does(1, line);
        stage.settle();
        CHECK(is_greeted);
    }
}

TEST_CASE("counts are printed while a command waits for nodes") {
    Theatre stage;
    Json reply;
    stage.during = [&] {
        stage.watchers.does(2, "stats");
        stage.during = [&] { reply = stage.watchers.reply(2); };
    };
    stage.watchers.does(1, "surface another iso=0.25");
    stage.director.step();
    CHECK(reply["ok"] == true);
    CHECK(reply["result"]["surfaces"].size() == 1);
    CHECK(stage.watchers.reply(1)["ok"] == true);
}

TEST_CASE("counts do not wait for a command that came at the same moment") {
    Theatre stage;
    Json reply;
    stage.during = [&] { reply = stage.watchers.reply(2); };
    stage.watchers.does(1, "surface another iso=0.25");
    stage.watchers.does(2, "stats");
    stage.director.step();
    CHECK(reply["ok"] == true);
    CHECK(stage.watchers.reply(1)["ok"] == true);
}

TEST_CASE("a node can be killed by a line that came with the command that waits for it") {
    Theatre stage;
    stage.watchers.does(1, "surface sphere iso=0.25");
    stage.watchers.does(2, "kill gp-0");
    stage.settle();
    CHECK(stage.watchers.reply(2)["ok"] == true);
    CHECK(stage.watchers.reply(1)["ok"] == true);
    CHECK(stage.launches == 2);
    CHECK(stage.watchers.last("state")["surfaces"].size() == 2);
}

TEST_CASE("a surface and an orbit are canceled while they wait for nodes, but no picture is") {
    Theatre stage;
    for (const char* line : {"surface another iso=0.25", "orbit 40"}) {
        stage.during = [&] { stage.watchers.says({{"cancel", true}}); };
        stage.watchers.texts.clear();
        stage.watchers.does(1, line);
        stage.settle();
        CHECK_MESSAGE(stage.watchers.reply(1)["ok"] == false, line);
        CHECK_MESSAGE(stage.watchers.reply(1)["error"] == "canceled", line);
        CHECK(stage.watchers.last("state")["surfaces"].size() == 1);
    }
    stage.watchers.texts.clear();
    stage.watchers.does(1, "view 30 20");
    stage.director.step();
    stage.during = [&] { stage.watchers.says({{"cancel", true}}); };
    stage.settle();
    CHECK(stage.watchers.last("note").is_null());
    // The late answers of what was canceled do not harm what follows.
    stage.watchers.does(2, "surface another iso=0.25");
    stage.watchers.does(3, "digest");
    stage.settle();
    CHECK(stage.watchers.reply(2)["ok"] == true);
    Theatre fresh;
    fresh.watchers.does(1, "view 30 20");
    fresh.watchers.does(2, "surface another iso=0.25");
    fresh.watchers.does(3, "digest");
    fresh.settle();
    CHECK(stage.watchers.reply(3)["result"] == fresh.watchers.reply(3)["result"]);
}

TEST_CASE("a question about a mesh is canceled, and the next one does not get its answers") {
    Theatre fresh;
    const std::string name = fresh.watchers.last("state")["surfaces"][0]["name"];
    const std::string question = "certificate " + name;
    fresh.watchers.does(2, question);
    fresh.settle();
    REQUIRE(fresh.watchers.reply(2)["ok"] == true);
    // Parts for the first question have no cells of the triangles, which the second needs.
    for (const std::string& line : {"components " + name, question}) {
        Theatre stage;
        stage.during = [&] { stage.watchers.says({{"cancel", true}}); };
        stage.watchers.texts.clear();
        stage.watchers.does(1, line);
        stage.watchers.does(2, question);
        stage.settle();
        CHECK_MESSAGE(stage.watchers.reply(1)["error"] == "canceled", line);
        CHECK(stage.watchers.reply(2) == fresh.watchers.reply(2));
    }
}

TEST_CASE("a cancellation that no command takes does not cancel the picture behind it") {
    Theatre stage;
    const std::string name = stage.watchers.last("state")["surfaces"][0]["name"];
    stage.during = [&] { stage.watchers.says({{"cancel", true}}); };
    stage.watchers.texts.clear();
    stage.watchers.frames.clear();
    stage.watchers.does(1, "components " + name + " show=largest");  // A mask must be whole.
    stage.steps();
    CHECK(stage.watchers.reply(1)["ok"] == true);
    CHECK(stage.watchers.last("note").is_null());
    CHECK(stage.watchers.frames.size() == 1);
}

TEST_CASE("viewers are told of a node that does not answer") {
    Theatre stage;
    stage.machine->tell_suspect("gp-0 (process 71) has not answered for 2.0 s");
    CHECK(stage.watchers.last("note")["text"] == "gp-0 (process 71) has not answered for 2.0 s");
    CHECK(stage.watchers.last("note")["level"] == "info");
}

TEST_CASE("viewers are told of a computer that has joined, and see that no other is here") {
    Theatre stage;
    stage.machine->tell_computer("n4 with 16 cores has joined");
    CHECK(stage.watchers.last("note")["text"] == "n4 with 16 cores has joined");
    CHECK(stage.watchers.last("note")["level"] == "info");
    stage.watchers.does(1, "computers");
    stage.watchers.does(2, "computers use");
    stage.watchers.does(3, "computers release n4");
    stage.settle();
    CHECK(stage.watchers.reply(1)["text"] == "all nodes run on this computer");
    CHECK(stage.watchers.reply(2)["error"] == "this machine has no other computers");
    CHECK(stage.watchers.reply(3)["error"] == "no computer of this machine is called 'n4'");
    CHECK(stage.launches == 1);
}
