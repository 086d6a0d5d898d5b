// The volumes of a time series, shown one after the other on a simulated machine.
#include <doctest/doctest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "host/base/error.hpp"
#include "host/commands/commands.hpp"
#include "host/commands/text/picture_text.hpp"
#include "host/phantom/phantom.hpp"
#include "tests/system/mortal_machine.hpp"

using namespace pxpl5;
using namespace pxpl5::host;

namespace {

Topology small_machine() {
    Topology topology;
    topology.gp.count = 2;
    topology.renderer.count = 2;
    topology.frame_buffer.count = 1;
    topology.gp_memory_mib = 64;
    topology.seed = 5;
    return topology;
}

/// The value of a field.
template <class T>
T field(const Fields& fields, const std::string& name) {
    for (const Field& each : fields) {
        if (each.name == name) {
            return std::get<T>(each.value);
        }
    }
    FAIL("no field " << name);
    return {};
}

/// A session that shows the heart.
struct Ward {
    explicit Ward(MachinePort& machine, const std::string& options = "") : session(machine) {
        session.scene.overlay = false;
        does("size 128x112");
        does("load phantom:heart" + options);
        does("surface blood iso=242.5");
        does("surface heart iso=7.5 opacity=0.25");
        does("view 20 10");
        does("clip A 20");
    }
    Reply does(const std::string& line) { return run_command(session, parse_line(line)); }
    std::uint64_t digest() { return picture_digest(session.frames.draw()); }

    Session session;
};

/// Digest of the picture of the volume, loaded by its number.
std::uint64_t loaded_digest(int frame) {
    test::SimulatedMachine machine{small_machine()};
    return Ward(machine, " frame=" + std::to_string(frame)).digest();
}

/// Volume of the left ventricle's cavity, from the lengths that the phantom states.
double cavity_ml(bool contracted) {
    const auto infos = phantoms();
    const auto heart = std::ranges::find(infos, "phantom:heart", &PhantomInfo::name);
    REQUIRE(heart != infos.end());
    const auto length = [&](const std::string& axis) {
        const std::string name = axis + " half axis, " + (contracted ? "contracted" : "relaxed");
        return std::ranges::find(heart->lengths, name, &PhantomLength::name)->length_mm;
    };
    return 4 * M_PI / 3 * length("long") * std::pow(length("short"), 2) / 1000;
}

}  // namespace

TEST_CASE("a volume that is shown later is the volume that is loaded by its number") {
    test::SimulatedMachine machine{small_machine()};
    Ward ward(machine);
    const std::uint64_t first = ward.digest();
    for (const int frame : {2, 13, 30}) {
        ward.does("time " + std::to_string(frame));
        CHECK(ward.digest() == loaded_digest(frame));
    }
    ward.does("time next");
    CHECK(ward.digest() == first);
    CHECK(ward.session.scene.surfaces.size() == 2);
    CHECK(ward.session.scene.clips.size() == 1);
    ward.does("time previous");
    CHECK(ward.digest() == loaded_digest(30));
    ward.does("time at=361");
    CHECK(ward.session.volumes.volume().frame == 13);
    ward.does("time at=870");
    CHECK(ward.session.volumes.volume().frame == 30);
    CHECK_THROWS_WITH_AS(ward.does("time at=900"),
                         "time: at=900 ms is beyond the last volume of phantom:heart: give 0 to "
                         "870",
                         RequestError);
}

TEST_CASE("texts and slices say which volume they are of") {
    test::SimulatedMachine machine{small_machine()};
    Ward ward(machine, " frame=13");
    const std::string info = ward.does("info").text;
    CHECK(info.find("\ntime series: 13/30, 360 ms; volumes are 30 ms apart\n") !=
          std::string::npos);
    const Reply slice = ward.does("slice z 30 heart.png");
    CHECK(slice.text.starts_with("13/30, 360 ms: slice z 30 of 0..63: 128 x 128 voxels"));
    CHECK(field<std::int64_t>(slice.fields, "frame") == 13);
    CHECK(field<double>(slice.fields, "time_ms") == 360);
    REQUIRE(machine.exported.size() == 1);
    CHECK(machine.exported[0].description.starts_with("13/30, 360 ms: slice z 30"));
    ward.does("time 1");
    const Reply first = ward.does("slice z 30 heart.png");  // The blood has more voxels there.
    for (const std::string name : {"window", "level"}) {
        CHECK(field<double>(first.fields, name) == field<double>(slice.fields, name));
    }
    ward.does("load phantom:sphere");
    CHECK(ward.does("info").text.find("time series") == std::string::npos);
    ward.does("slice z 30 sphere.png");
    CHECK(machine.exported[2].description.starts_with("slice z 30"));
}

TEST_CASE("volumes that were shown are kept until another volume is loaded") {
    test::SimulatedMachine machine{small_machine()};
    Ward ward(machine);
    ward.does("time 2");
    ward.does("time 3");
    CHECK(ward.session.series.kept().volumes == 2);
    CHECK(ward.session.series.kept().bytes == 2 * 128 * 128 * 64 * sizeof(std::int16_t));
    ward.does("time 1");
    CHECK(ward.session.series.kept().volumes == 2);
    ward.does("load phantom:sphere");
    CHECK(ward.session.series.kept().volumes == 0);
}

TEST_CASE("a surface without triangles has no volume") {
    test::SimulatedMachine machine{small_machine()};
    Ward ward(machine);
    ward.does("remove heart");
    ward.does("surface blood iso=-90.5");  // All voxels are above.
    const Reply reply = ward.does("curve to=2");
    const auto rows = field<std::vector<Fields>>(reply.fields, "rows");
    CHECK(field<std::int64_t>(rows[0], "triangles") == 0);
    CHECK_NOTHROW(field<std::nullptr_t>(rows[0], "volume_ml"));
    CHECK(reply.text.find("blood: no volume at some time") == 0);
}

TEST_CASE("undo goes back to the volume of before, and a drag is one step") {
    test::SimulatedMachine machine{small_machine()};
    Ward ward(machine);
    const std::uint64_t first = ward.digest();
    ward.does("mark");
    ward.does("time 3");
    ward.does("time 8");
    const std::uint64_t eighth = ward.digest();
    ward.does("mark");
    ward.does("surface blood iso=200");
    ward.does("undo");
    CHECK(ward.digest() == eighth);
    ward.does("undo");
    CHECK(ward.session.volumes.volume().frame == 1);
    CHECK(ward.digest() == first);
    ward.does("redo");
    CHECK(ward.digest() == eighth);
}

TEST_CASE("a script of the session shows the same volume") {
    test::SimulatedMachine machine{small_machine()};
    Ward ward(machine);
    ward.does("time 5");
    ward.does("time next");
    ward.does("time next");
    const std::uint64_t seventh = ward.digest();
    const auto folder =
        std::filesystem::temp_directory_path() / ("pxpl5-series-" + std::to_string(getpid()));
    std::filesystem::create_directory(folder);
    for (const std::string form : {"steps", "scene"}) {
        const std::string script = (folder / (form + ".pxpl5")).string();
        ward.does("history " + script + " form=" + form);
        test::SimulatedMachine other{small_machine()};
        Session again(other);
        again.scene.overlay = false;
        run_command(again, parse_line("play " + script));
        CHECK_MESSAGE(again.volumes.volume().frame == 7, form);
        CHECK_MESSAGE(picture_digest(again.frames.draw()) == seventh, form);
    }
    std::filesystem::remove_all(folder);
}

TEST_CASE("what is no volume of the series is refused, and changes nothing") {
    test::SimulatedMachine machine{small_machine()};
    Ward ward(machine);
    ward.does("time 4");
    const std::uint64_t fourth = ward.digest();
    for (const char* line : {"time 0", "time 31", "time 2.5", "time soon", "time 3 at=60",
                             "cine from=5 to=3", "curve to=31"}) {
        CHECK_THROWS_AS(ward.does(line), RequestError);
    }
    CHECK_THROWS_WITH_AS(ward.does("time 31"),
                         "time: 31 is no volume of phantom:heart, which has 30: give 1 to 30",
                         RequestError);
    CHECK(ward.digest() == fourth);
    ward.does("load phantom:sphere");
    CHECK_THROWS_WITH_AS(ward.does("time 1"),
                         "time: phantom:sphere is one volume; load a file of several volumes, for "
                         "example phantom:heart",
                         RequestError);
    CHECK_THROWS_WITH_AS(ward.does("load phantom:sphere frame=2"),
                         "phantom:sphere: frame is 2, but the phantom has one volume: load it "
                         "without frame=",
                         RequestError);
}

TEST_CASE("the curve of the moving heart has the volumes of its formula") {
    test::SimulatedMachine machine{small_machine()};
    Ward ward(machine);
    ward.does("time 9");
    const std::uint64_t ninth = ward.digest();
    const Reply reply = ward.does("curve");
    const auto surfaces = field<std::vector<Fields>>(reply.fields, "surfaces");
    REQUIRE(surfaces.size() == 2);
    const double largest = cavity_ml(false), least = cavity_ml(true);
    CHECK(field<double>(surfaces[0], "largest_ml") == doctest::Approx(largest).epsilon(0.01));
    CHECK(field<double>(surfaces[0], "least_ml") == doctest::Approx(least).epsilon(0.01));
    CHECK(std::abs(field<double>(surfaces[0], "ejection_fraction") - (1 - least / largest)) < 0.01);
    const auto rows = field<std::vector<Fields>>(reply.fields, "rows");
    CHECK(rows.size() == 60);
    CHECK(field<double>(rows[12], "time_ms") == doctest::Approx(360));
    CHECK_MESSAGE(ward.digest() == ninth, "the volume of before is shown again");
    CHECK(ward.session.volumes.volume().frame == 9);
}

TEST_CASE("the curve of some components is that of what is drawn") {
    test::SimulatedMachine machine{small_machine()};
    Ward ward(machine);
    ward.does("remove heart");
    ward.does("surface blood iso=150");  // With the right ventricle's blood.
    const auto largest = [&] {
        return field<double>(
            field<std::vector<Fields>>(ward.does("curve to=1").fields, "surfaces")[0],
            "largest_ml");
    };
    const double both = largest();
    ward.does("components blood show=largest");
    CHECK(largest() < 0.95 * both);
    CHECK(largest() > 100);
}

TEST_CASE("a node that dies while a volume is shown costs nothing but time") {
    const std::uint64_t sixth = loaded_digest(6);
    int deaths = 0;
    for (int at = 1; at <= 401; at += 40) {
        int extractions = 0, step = 0;
        bool is_due = false;
        std::function<void()> during;
        const auto fate = [&]() -> std::optional<MachineError> {
            if (is_due && ++step == at) {
                ++deaths;
                return test::killed();
            }
            return std::nullopt;
        };
        test::MortalMachine machine(small_machine(), extractions, fate, during,
                                    [] { return test::Disturbance{}; });
        Ward ward(machine);
        ward.does("time 2");
        is_due = true;
        ward.does("time 6");
        is_due = false;
        CHECK_MESSAGE(ward.session.volumes.volume().frame == 6, "death at step " << at);
        CHECK_MESSAGE(ward.digest() == sixth, "death at step " << at);
    }
    CHECK(deaths > 2);
}
