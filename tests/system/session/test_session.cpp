// A session on a simulated machine: what one request leaves behind for the next.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <stdexcept>
#include <vector>

#include "host/base/error.hpp"
#include "host/session/session.hpp"
#include "tests/system/error_of.hpp"
#include "tests/system/machine_of.hpp"
#include "tests/system/session/canceling.hpp"
#include "tests/system/simulated_machine.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using test::machine_of;

namespace {

constexpr Color gray{160, 160, 160};

/// Loads a sphere and shows it in a picture of this size.
void show_sphere(Session& session, int width, int height, double isovalue) {
    session.volumes.load("phantom:sphere");
    session.scene.size = {width, height};
    session.surfaces.set("s", isovalue, CaseRule::watertight, gray);
}

}  // namespace

TEST_CASE("an orbit that is broken off leaves no frame and no turned camera behind") {
    test::SimulatedMachine machine(machine_of(2, 2));
    Session session(machine);
    show_sphere(session, 150, 130, 0.5);
    const Picture before = session.frames.draw();
    CHECK_THROWS_AS(session.frames.orbit(7,
                                         [](int index, const Picture&, const Camera&) {
                                             if (index == 2) {
                                                 throw std::runtime_error("the disk is full");
                                             }
                                         }),
                    std::runtime_error);
    CHECK(session.frames.draw().rgba == before.rgba);
    session.scene.size = {64, 64};
    CHECK(session.frames.draw().rgba.size() == 64 * 64);
}

TEST_CASE("a frame asked for too early does not stand in the way of later ones") {
    test::SimulatedMachine machine(machine_of(1, 1));
    Session session(machine);
    CHECK(test::error_of([&] { session.frames.draw(); }).find("no volume is loaded") == 0);
    CHECK(test::error_of([&] {
              session.frames.orbit(3, [](int, const Picture&, const Camera&) {});
          }).find("no volume") == 0);
    session.volumes.load("phantom:sphere");
    CHECK(session.frames.draw().rgba.size() == 512 * 512);
}

TEST_CASE("when all GPs refuse a volume, the next volume is not blamed for it") {
    test::SimulatedMachine machine(machine_of(4, 1, 11, 1));
    Session session(machine);
    const std::string error = test::error_of([&] { session.volumes.load("phantom:head"); });
    CHECK(error.find("phantom:head") == 0);
    CHECK(error.find("GPs") != std::string::npos);
    CHECK(!session.volumes.has_volume());
    CHECK_NOTHROW(session.volumes.load("phantom:sphere"));
    CHECK_NOTHROW(session.surfaces.set("s", 0.5, CaseRule::watertight, gray));
    CHECK(session.frames.draw().rgba.size() == 512 * 512);
}

TEST_CASE("surfaces that no GP has room for are drawn like others, and come back with room") {
    constexpr int surfaces = 12;
    std::vector<Picture> pictures;
    std::vector<std::uint64_t> digests;
    for (const int memory_mib : {256, 6}) {
        test::SimulatedMachine machine(machine_of(2, 1, 11, memory_mib));
        Session session(machine);
        session.volumes.load("phantom:letters");
        std::int64_t left_out = 0;
        const auto set = [&](int number) {
            return session.surfaces.set("s" + std::to_string(number), 100 + number,
                                        CaseRule::watertight, gray);
        };
        for (int number = 0; number < surfaces; ++number) {
            left_out += set(number).slabs_left_out;
        }
        CHECK((left_out > 0) == (memory_mib == 6));
        pictures.push_back(session.frames.draw());
        for (int number = 0; number < surfaces; ++number) {
            digests.push_back(session.meshes.digest("s" + std::to_string(number)));
        }
        for (int number = 1; number < surfaces; ++number) {
            session.surfaces.remove("s" + std::to_string(number));
        }
        pictures.push_back(session.frames.draw());
        CHECK(set(0).slabs_left_out == 0);
    }
    CHECK(pictures[0].rgba == pictures[2].rgba);
    CHECK(pictures[1].rgba == pictures[3].rgba);
    for (std::size_t i = 0; i < surfaces; ++i) {
        CHECK(digests[i] == digests[surfaces + i]);
    }
}

TEST_CASE("the newest isovalue of a surface is what is drawn") {
    test::SimulatedMachine machine(machine_of(3, 2));
    Session session(machine);
    show_sphere(session, 100, 100, 0.5);
    const Picture large = session.frames.draw();
    session.surfaces.set("s", 1500.5, CaseRule::watertight, gray);
    CHECK(session.frames.draw().rgba != large.rgba);
    session.surfaces.set("s", 0.5, CaseRule::watertight, gray);
    CHECK(session.frames.draw().rgba == large.rgba);
}

TEST_CASE("a sweep shows each isovalue and leaves the surface as it was") {
    test::SimulatedMachine machine(machine_of(2, 2));
    Session session(machine);
    session.volumes.load("phantom:sphere");
    session.scene.size = {100, 100};
    const std::vector<double> isovalues = {0.5, 900.5, 1500.5};
    std::vector<std::vector<std::uint32_t>> wanted;
    for (const double isovalue : isovalues) {
        session.surfaces.set("s", isovalue, CaseRule::watertight, gray);
        wanted.push_back(session.frames.draw().rgba.copy());
    }
    session.surfaces.set("s", 300.5, CaseRule::watertight, gray);
    const Picture before = session.frames.draw();

    std::vector<std::vector<std::uint32_t>> shown;
    const SweepReport report = session.surfaces.sweep(
        "s", isovalues, [&](int index, const Picture& picture, const SurfaceReport& built) {
            CHECK(index == static_cast<int>(shown.size()));
            CHECK(built.triangles > 0);
            shown.push_back(picture.rgba.copy());
        });
    CHECK(shown == wanted);
    CHECK(report.changes == 3);
    CHECK(report.picture_ms.median >= report.extraction_ms.median);
    CHECK(session.surfaces.find("s")->isovalue == 300.5);
    CHECK(session.frames.draw().rgba == before.rgba);

    // With a screen door, too, a picture is one frame.
    session.scene.surfaces[0].opacity = 8;
    const Picture behind_door = session.frames.draw();
    const std::uint32_t frame = session.frames.last().frame;
    session.surfaces.sweep("s", isovalues, [](int, const Picture&, const SurfaceReport&) {});
    CHECK(session.frames.last().frame == frame + 3);
    CHECK(session.frames.draw().rgba == behind_door.rgba);
    session.scene.surfaces[0].opacity = full_opacity;

    CHECK_THROWS_AS(session.surfaces.sweep("s", isovalues,
                                           [](int, const Picture&, const SurfaceReport&) {
                                               throw RequestError(ExitCode::failed,
                                                                  "the disk is full");
                                           }),
                    RequestError);
    CHECK(session.frames.draw().rgba == before.rgba);
    CHECK(test::error_of([&] {
              session.surfaces.sweep("t", isovalues, {});
          }).find("no surface 't'") != std::string::npos);
}

TEST_CASE("a frame waits for the isovalue that it shows, whichever comes first") {
    const std::vector<double> isovalues = {0.5, 900.5, 1500.5, 300.5};
    std::vector<std::vector<std::uint32_t>> wanted;
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
        Topology topology = machine_of(3, 2);
        topology.seed = seed;
        CAPTURE(seed);
        test::SimulatedMachine machine(topology);
        Session session(machine);
        show_sphere(session, 60, 50, 100.5);
        std::vector<std::vector<std::uint32_t>> shown;
        session.surfaces.sweep("s", isovalues,
                               [&](int, const Picture& picture, const SurfaceReport&) {
                                   shown.push_back(picture.rgba.copy());
                               });
        wanted = seed == 0 ? shown : wanted;
        REQUIRE(shown.size() == isovalues.size());
        CHECK(shown == wanted);
    }
}

TEST_CASE("views drawn one at a time are those drawn two at a time") {
    test::SimulatedMachine machine(machine_of(2, 2));
    Session session(machine);
    show_sphere(session, 100, 100, 0.5);
    std::vector<std::vector<std::uint32_t>> drawn[max_frames_in_flight];
    for (int in_flight = 1; in_flight <= max_frames_in_flight; ++in_flight) {
        const OrbitReport report = session.frames.orbit(
            4,
            [&](int, const Picture& picture, const Camera&) {
                drawn[in_flight - 1].push_back(picture.rgba.copy());
            },
            in_flight);
        CHECK(report.latency_ms.median > 0);
        CHECK(report.latency_ms.max <= report.elapsed_ms);
    }
    CHECK(drawn[0] == drawn[1]);
}

TEST_CASE("an announced frame is requested with the surface, and drawn once") {
    test::SimulatedMachine machine(machine_of(2, 2));
    Session session(machine);
    show_sphere(session, 150, 130, 0.5);
    const Picture plain = session.frames.draw();
    const std::uint32_t before = session.frames.last().frame;
    session.surfaces.set("s", 0.2, CaseRule::watertight, gray);
    const Picture expected = session.frames.draw();
    CHECK(expected.rgba != plain.rgba);
    session.surfaces.set("s", 0.5, CaseRule::watertight, gray);
    session.frames.announce(Frames::Moving{session.scene.size, 0});
    session.surfaces.set("s", 0.2, CaseRule::watertight, gray);
    CHECK(session.frames.has_frame_ahead());
    CHECK(session.frames.draw().rgba == expected.rgba);
    CHECK(session.frames.last().frame == before + 2);
    CHECK_FALSE(session.frames.has_frame_ahead());
    CHECK(session.frames.draw().rgba == expected.rgba);
    CHECK(session.frames.last().frame == before + 3);
}

TEST_CASE("an announced frame that does not show the scene is dropped") {
    test::SimulatedMachine machine(machine_of(2, 2));
    Session session(machine);
    show_sphere(session, 150, 130, 0.5);
    session.surfaces.set("t", 0.2, CaseRule::watertight, {20, 200, 20});
    const Picture expected = session.frames.draw();
    session.scene.camera.angles.azimuth_deg = 70;
    session.frames.announce(Frames::Moving{session.scene.size, 0});
    session.surfaces.set("s", 0.5, CaseRule::watertight, gray);
    session.scene.camera.angles.azimuth_deg = 0;
    CHECK(session.frames.draw().rgba == expected.rgba);
    session.frames.announce(Frames::Moving{session.scene.size, 0});
    session.surfaces.set("s", 0.5, CaseRule::watertight, gray);
    session.surfaces.remove("t");
    const Picture one = session.frames.draw();
    CHECK(session.frames.draw().rgba == one.rgba);
    session.frames.announce(Frames::Moving{session.scene.size, 0});
    session.surfaces.set("s", 0.2, CaseRule::watertight, gray);
    session.volumes.load("phantom:sphere");
    CHECK_FALSE(session.frames.has_frame_ahead());
    CHECK(session.frames.draw().rgba.size() == 150 * 130);
}

TEST_CASE("a canceled question spoils no later one, also if its volume is discarded meanwhile") {
    test::SimulatedMachine machine(machine_of(3, 1));
    Session session(machine);
    const test::Canceling viewer(machine);
    constexpr std::array isovalues = {0.2, 0.5};
    const auto ask = [&] {
        std::vector<std::uint64_t> triangles;
        for (const AtlasRow& row : session.meshes.measure(isovalues, CaseRule::watertight)) {
            triangles.push_back(row.triangles);
        }
        return triangles;
    };
    session.volumes.load("phantom:sphere");
    const std::vector<std::uint64_t> first = ask();
    CHECK(first[0] > 0);
    for (int times = 0; times < 2; ++times) {
        // All GPs answer after the cancellation.
        viewer.press();
        CHECK_THROWS_AS(ask(), Canceled);
        CHECK(ask() == first);
        viewer.press();
        CHECK_THROWS_AS(ask(), Canceled);
        session.load_settings.progress = [&](const LoadProgress&) { viewer.press(); };
        CHECK_THROWS_AS(session.volumes.load("phantom:letters"), Canceled);
        CHECK_FALSE(session.volumes.has_volume());
        session.load_settings.progress = {};
        session.volumes.load("phantom:sphere");
        CHECK(ask() == first);
    }
}

TEST_CASE("a GP that has no room for a canceled surface spoils neither the old nor the next one") {
    constexpr double empty = 30000, large = 100;  // Isovalues of the letters.
    for (std::uint64_t seed = 1; seed <= 30; ++seed) {
        CAPTURE(seed);
        Topology topology = machine_of(2, 1, 11, 6);
        topology.seed = seed;
        test::SimulatedMachine machine(topology);
        Session session(machine);
        const test::Canceling viewer(machine);
        const auto set = [&](const std::string& name, double isovalue) {
            return session.surfaces.set(name, isovalue, CaseRule::watertight, gray).triangles;
        };
        session.volumes.load("phantom:letters");
        set("old", empty);
        std::int64_t left_out = 0;
        for (int n = 0; n < 16 && left_out == 0; ++n) {
            const std::string name = "s" + std::to_string(n);
            set(name, large + n);
            left_out = session.surfaces.report_of(name).slabs_left_out;
        }
        REQUIRE(left_out > 0);
        viewer.press();
        CHECK_THROWS_AS(set("old", large), Canceled);
        REQUIRE(session.surfaces.find("old"));
        CHECK(session.surfaces.find("old")->isovalue == empty);
        viewer.press();
        CHECK_THROWS_AS(set("new", large), Canceled);
        CHECK(!session.surfaces.find("new"));
        session.surfaces.remove("old");
        CHECK(set("next", empty) == 0);
        CHECK_NOTHROW(session.frames.draw());
    }
}
