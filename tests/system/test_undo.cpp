// Undo, redo and the script of a session, on a simulated machine.
#include <doctest/doctest.h>

#include <filesystem>
#include <fstream>
#include <glm/glm.hpp>

#include "host/base/error.hpp"
#include "host/commands/commands.hpp"
#include "host/commands/text/picture_text.hpp"
#include "tests/system/simulated_machine.hpp"

using namespace pxpl5;
using namespace pxpl5::host;

namespace {

Topology small_machine() {
    Topology topology;
    topology.gp.count = 2;
    topology.renderer.count = 2;
    topology.frame_buffer.count = 1;
    topology.gp_memory_mib = 64;
    topology.seed = 3;
    return topology;
}

struct Desk {
    test::SimulatedMachine machine{small_machine()};
    Session session{machine};

    Desk() {
        session.scene.overlay = false;
        does("size 160x140");
        does("load phantom:pelvis");
        does("surface bone");
    }
    Reply does(const std::string& line) { return run_command(session, parse_line(line)); }
    std::uint64_t digest() { return picture_digest(session.frames.draw()); }
};

}  // namespace

TEST_CASE("undo and redo go through every picture of a session, back and forth") {
    Desk desk;
    std::vector<std::uint64_t> digests = {desk.digest()};
    for (const char* line : {"surface skin opacity=0.5",
                             "surface skin rim=0.75",
                             "pick 80 70 set=bone",
                             "surface bone iso=400",
                             "components bone show=largest",
                             "surface bone table=lorensen1987",
                             "surface bone visible=no",
                             "surface bone visible=yes",
                             "clip L",
                             "clip box 9,9,9 100,100,40",
                             "clip box off",
                             "planes x=40 z=20",
                             "planes y=30 window=300 level=50",
                             "planes x=off",
                             "planes off",
                             "compare bone",
                             "compare bone off",
                             "view 30 10 roll=20 pan=9,-5",
                             "light 1 off",
                             "material ambient=0.4",
                             "background white",
                             "remove skin"}) {
        desk.does("mark");
        desk.does(line);
        digests.push_back(desk.digest());
    }
    for (std::size_t i = digests.size() - 1; i-- > 0;) {
        const std::string undone = desk.does("undo").text;
        CHECK_MESSAGE(desk.digest() == digests[i], undone);
    }
    for (std::size_t i = 1; i < digests.size(); ++i) {
        const std::string redone = desk.does("redo").text;
        CHECK_MESSAGE(desk.digest() == digests[i], redone);
    }
    CHECK_THROWS_AS(desk.does("redo"), RequestError);
}

TEST_CASE("the number of the step grows with changes and falls with undo, also past the limit") {
    Desk desk;
    const std::uint64_t first = desk.session.history.step();
    const auto change = [&](std::size_t number) {
        desk.does("mark");
        desk.does("material ambient=" + std::to_string(0.1 + 0.001 * static_cast<double>(number)));
    };
    change(0);
    desk.does("digest");
    CHECK(desk.session.history.step() == first + 1);
    desk.does("undo");
    CHECK(desk.session.history.step() == first);
    desk.does("redo");
    CHECK(desk.session.history.step() == first + 1);
    for (std::size_t i = 1; i < max_undo_steps + 5; ++i) {
        change(i);
    }
    CHECK(desk.session.history.step() == first + max_undo_steps + 5);
    desk.does("load phantom:sphere");
    CHECK(desk.session.history.step() >= first + max_undo_steps + 5);
}

TEST_CASE("a pick finds the same place after a roll and a pan") {
    Desk desk;
    Session& session = desk.session;
    desk.does("view 20 10");
    const auto before = session.frames.pick(80, 70);
    REQUIRE(before);
    desk.does("view roll=40 pan=35,-20");
    const CameraMatrices m =
        camera_matrices(session.scene.camera, session.frames.subject(), 160.0 / 140.0);
    const glm::dvec4 clip = m.projection * m.patient_to_eye * glm::dvec4(before->pick.p_mm, 1);
    const int x = static_cast<int>((clip.x / clip.w + 1) / 2 * 160);
    const int y = static_cast<int>((1 - clip.y / clip.w) / 2 * 140);
    CHECK(glm::distance(glm::dvec2(x, y), glm::dvec2(80, 70)) > 10);
    const auto after = session.frames.pick(x, y);
    REQUIRE(after);
    // Half a pixel's diagonal, of a pixel of 5 mm on a surface that is seen aslant.
    CHECK(glm::distance(after->pick.p_mm, before->pick.p_mm) < 5);
}

TEST_CASE("undo does not cross a load") {
    Desk desk;
    desk.does("load phantom:sphere");
    CHECK_THROWS_AS(desk.does("undo"), RequestError);
}

TEST_CASE("a session's script, played, leads to the same picture and to the same steps") {
    const std::filesystem::path script =
        std::filesystem::temp_directory_path() / "pxpl5-test-undo-script.txt";
    Desk first;
    for (const char* line :
         {"surface bone iso=300", "surface bone iso=350", "view 10 20 zoom=2", "undo", "redo",
          "mark", "view 10 30 zoom=2", "clip A 3", "digest", "undo", "surface skin", "remove bone",
          "undo", "pick 80 70 set=skin"}) {
        first.does(line);
    }
    first.does("history '" + script.string() + "'");
    Desk second;
    second.does("play '" + script.string() + "'");
    std::filesystem::remove(script);
    CHECK(second.digest() == first.digest());
    for (int step = 0; step < 3; ++step) {
        first.does("undo");
        second.does("undo");
        CHECK(second.digest() == first.digest());
    }
}

TEST_CASE("a script that fails says where, and one that plays itself ends") {
    const std::filesystem::path script =
        std::filesystem::temp_directory_path() / "pxpl5-test-play-script.txt";
    Desk desk;
    std::ofstream(script) << "# first\nview 10 20\nview over there or so\n";
    try {
        desk.does("play '" + script.string() + "'");
        FAIL("nothing was refused");
    } catch (const RequestError& error) {
        CHECK(std::string(error.what()).find("line 3, 'view over there or so': view takes") !=
              std::string::npos);
    }
    CHECK(desk.session.scene.camera.angles.azimuth_deg == 10);
    std::ofstream(script) << "play '" << script.string() << "'\n";
    CHECK_THROWS_AS(desk.does("play '" + script.string() + "'"), RequestError);
    std::filesystem::remove(script);
    CHECK_THROWS_AS(desk.does("play '" + script.string() + "'"), RequestError);
}
