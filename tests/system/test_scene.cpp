// A PPHIGS archive in a session: in the place of a volume, and that of a volume in its place.
#include <doctest/doctest.h>
#include <fmt/core.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <functional>

#include "host/base/error.hpp"
#include "host/session/session.hpp"
#include "tests/system/error_of.hpp"
#include "tests/system/simulated_machine.hpp"

using namespace pxpl5;
using namespace pxpl5::host;

namespace {

Topology machine_of(int gps, int gp_memory_mib = 64) {
    Topology topology;
    topology.gp.count = gps;
    topology.renderer.count = topology.frame_buffer.count = 1;
    topology.gp_memory_mib = gp_memory_mib;
    topology.seed = 5;
    return topology;
}

/// A file that is gone when its test is over.
struct ArchiveFile {
    explicit ArchiveFile(const std::string& elements) {
        std::ofstream(path) << "structure s posted {\n" << elements << "};\n";
    }
    ~ArchiveFile() { std::filesystem::remove(path); }
    std::string path =
        (std::filesystem::temp_directory_path() / fmt::format("pxpl5-scene-{}.phigs", getpid()))
            .string();
};

std::uint32_t pixel(const Picture& picture, int x, int y) {
    return picture.rgba[static_cast<std::size_t>(y * picture.width + x)] & 0xFF'FF'FF;
}

}  // namespace

TEST_CASE("a scene's colors, sides and gloss arrive in the picture") {
    // Left a square seen from its blue back, right one that is culled; a red sphere in the middle.
    const ArchiveFile file(
        "color polygon { diff 0 255 0 255  0 0 255 255 spec 51 51 51 40 51 51 51 40 };\n"
        "polygon 4 { -3 -1 0; -3 1 0; -1 1 0; -1 -1 0; };\n"
        "polygon5 4 131 { 1 -1 0; 1 1 0; 3 1 0; 3 -1 0; };\n"
        "color sphere { diff 255 0 0 255 }; sphere 0 0 0 0.8;\n");
    test::SimulatedMachine machine(machine_of(2));
    Session session(machine);
    session.volumes.load(file.path);
    CHECK(session.scene.material.specular == doctest::Approx(0.2));
    CHECK(session.scene.material.specular_power == 40);
    session.scene.size = {200, 200};
    session.scene.material = {1, 0, 1};
    session.scene.lights.clear();
    const Picture picture = session.frames.draw();
    const Color background = session.scene.background;
    CHECK(pixel(picture, 100, 100) == 0x0000FF);
    CHECK(pixel(picture, 40, 100) == 0xFF0000);
    CHECK(pixel(picture, 160, 100) == (background.r | background.g << 8 | background.b << 16));
}

TEST_CASE("a scene has no surfaces, and says so") {
    const ArchiveFile file("sphere 0 0 0 1;\n");
    test::SimulatedMachine machine(machine_of(1));
    Session session(machine);
    session.volumes.load(file.path);
    const std::string said = file.path +
                             " is a scene of polygons, spheres and lines: it has no voxels and no "
                             "isosurfaces; load a volume for them";
    CHECK(test::error_of([&] { session.surfaces.set("s", 1, CaseRule::watertight, {}); }) == said);
    CHECK(test::error_of([&] { session.surfaces.remove("s"); }) == said);
    CHECK(test::error_of([&] { session.meshes.digest("s"); }) == said);
}

TEST_CASE("volume and scene take each other's place") {
    const ArchiveFile file("sphere 0 0 0 1;\n");
    test::SimulatedMachine machine(machine_of(3));
    Session session(machine);
    session.volumes.load("phantom:sphere");
    session.surfaces.set("s", 0.5, CaseRule::watertight, {160, 160, 160});
    const auto first = session.frames.draw().rgba;
    session.volumes.load(file.path);
    CHECK(session.scene.surfaces.empty());
    CHECK(!session.volumes.has_volume());
    REQUIRE(session.volumes.archive() != nullptr);
    CHECK(session.frames.draw().rgba != first);
    session.volumes.load("phantom:sphere");
    CHECK(session.volumes.archive() == nullptr);
    session.surfaces.set("s", 0.5, CaseRule::watertight, {160, 160, 160});
    CHECK(session.frames.draw().rgba == first);
}

TEST_CASE("a bad archive leaves what is loaded, and one that does not fit leaves nothing") {
    test::SimulatedMachine machine(machine_of(4, 1));
    Session session(machine);
    session.volumes.load("phantom:sphere");
    {
        const ArchiveFile bad("sphere 0 0 0;\n");
        CHECK(test::error_of([&] { session.volumes.load(bad.path); }) ==
              bad.path + ":2:13: found ';', expected radius, a number");
        CHECK(session.volumes.has_volume());
    }
    std::string many;
    for (int i = 0; i < 300'000; ++i) {
        many += fmt::format("sphere {} {} 0 1;\n", i % 400, i / 400);
    }
    const ArchiveFile large(many);
    const std::string error = test::error_of([&] { session.volumes.load(large.path); });
    CHECK(error.find(large.path) == 0);
    CHECK(error.find("bytes of local memory") != std::string::npos);
    CHECK(error.find("use more GPs to share the scene") != std::string::npos);
    CHECK(!session.volumes.has_volume());
    CHECK(session.volumes.archive() == nullptr);
    const ArchiveFile small("sphere 0 0 0 1;\n");
    CHECK_NOTHROW(session.volumes.load(small.path));
    CHECK(session.frames.draw().rgba.size() == 512 * 512);
}
