// The one invariant: what is drawn does not depend on the machine.
#include <doctest/doctest.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "host/machine/machine.hpp"
#include "host/session/session.hpp"
#include "tests/random_seed.hpp"
#include "tests/system/simulated_machine.hpp"

using namespace pxpl5;
using namespace pxpl5::host;

namespace {

/// All that a session gets out of a machine in a short run: two surfaces, their meshes, a still and
/// an orbit of partial regions.
struct Results {
    std::int64_t triangles = 0;
    std::vector<std::uint64_t> meshes;
    std::vector<std::vector<std::uint32_t>> pictures;
    std::int64_t instructions = 0;
    bool operator==(const Results&) const = default;
};

Results results_of(MachinePort& machine) {
    Session session(machine);
    session.volumes.load("phantom:letters");
    session.scene.size = {200, 150};
    const double middle = (session.volumes.volume().minimum + session.volumes.volume().maximum) / 2;
    Results results;
    results.triangles =
        session.surfaces.set("outer", middle, CaseRule::watertight, {200, 180, 160}).triangles +
        session.surfaces.set("inner", middle * 1.2, CaseRule::lorensen1987, {90, 120, 160})
            .triangles;
    results.meshes = {session.meshes.digest("outer"), session.meshes.digest("inner")};
    results.pictures.push_back(session.frames.draw().rgba.copy());
    results.instructions = session.frames.last().instructions;
    results.pictures.push_back(session.frames.draw_samples(4)->rgba.copy());
    results.pictures.push_back(session.frames.draw_samples(16)->rgba.copy());
    session.frames.orbit(3, [&](int, const Picture& picture, const Camera&) {
        results.pictures.push_back(picture.rgba.copy());
    });
    return results;
}

Topology plan(int gps, int renderers, std::uint64_t seed) {
    Topology topology;
    topology.gp.count = gps;
    topology.renderer.count = renderers;
    topology.frame_buffer.count = 1;
    topology.seed = seed;
    return topology;
}

Results simulated(const Topology& topology) {
    test::SimulatedMachine machine(topology);
    return results_of(machine);
}

Results by_processes(Topology topology, Transport transport) {
    topology.ring.transport = transport;
    MachineOptions options;
    options.binaries = PXPL5_BIN_DIR;
    options.run_base =
        std::filesystem::temp_directory_path() / ("pxpl5-same-picture-" + std::to_string(getpid()));
    Results results;
    {
        Machine machine(topology, options);
        results = results_of(machine);
        machine.shutdown();
    }
    std::filesystem::remove_all(options.run_base);
    return results;
}

const Results& least_machine() {
    static const Results results = simulated(plan(1, 1, 0));
    return results;
}

}  // namespace

TEST_CASE("the least machine draws something") {
    const Results& results = least_machine();
    CHECK(results.triangles > 1000);
    REQUIRE(results.pictures.size() == 6);
    for (const auto& picture : results.pictures) {
        CHECK(picture.size() == 200 * 150);
    }
    CHECK(results.pictures[1] != results.pictures[2]);
    CHECK(results.meshes[0] != results.meshes[1]);
}

TEST_CASE("meshes and pictures are the same for any machine and any order of arrival") {
    constexpr int seeds = test::seed_count(20);
    for (const auto& [gps, renderers] : {std::pair{1, 1}, {2, 2}, {3, 5}, {36, 16}}) {
        for (std::uint64_t seed = test::seed_or<std::uint64_t>(1);
             seed < test::seed_or<std::uint64_t>(1) + seeds; ++seed) {
            CAPTURE(gps);
            CAPTURE(renderers);
            CAPTURE(seed);
            CHECK(simulated(plan(gps, renderers, seed)) == least_machine());
        }
    }
}

TEST_CASE("a large picture from near by is the same for any machine") {
    const auto picture_of = [](const Topology& topology) {
        test::SimulatedMachine machine(topology);
        Session session(machine);
        session.volumes.load("phantom:pelvis");
        session.scene.size = {700, 530};
        session.scene.camera = {{40, 25}, 3};
        session.scene.lights = {{-28, 32, 0.7}, {50, -10, 0.3}, {0, 80, 0.2}};
        session.surfaces.set("bone", 250.5, CaseRule::asymptotic, {230, 220, 200});
        return session.frames.draw().rgba;
    };
    const auto least = picture_of(plan(1, 1, 0));
    for (const auto& [gps, renderers] : {std::pair{2, 2}, {3, 5}, {36, 16}}) {
        CAPTURE(gps);
        CHECK(picture_of(plan(gps, renderers, test::seed_or<std::uint64_t>(1))) == least);
    }
}

TEST_CASE("a scene is the same for any machine") {
    for (const char* name : {"molecule", "room", "tree"}) {
        const auto picture_of = [name](const Topology& topology) {
            test::SimulatedMachine machine(topology);
            Session session(machine);
            session.volumes.load(std::string(PXPL5_SOURCE_DIR) + "/host/phigs/archives/" + name +
                                 ".phigs");
            session.scene.size = {300, 200};
            session.scene.camera = {{25, 30}, 1.5};
            return session.frames.draw().rgba;
        };
        const auto least = picture_of(plan(1, 1, 0));
        CHECK(std::set<std::uint32_t>(least.begin(), least.end()).size() > 100);
        for (const auto& [gps, renderers] : {std::pair{2, 2}, {3, 5}, {36, 16}}) {
            CAPTURE(name);
            CAPTURE(gps);
            CHECK(picture_of(plan(gps, renderers, test::seed_or<std::uint64_t>(1))) == least);
        }
    }
}

TEST_CASE("meshes and pictures are the same from real processes, over ipc and tcp") {
    for (const Transport transport : {Transport::ipc, Transport::tcp}) {
        for (const auto& [gps, renderers] : {std::pair{1, 1}, {2, 2}, {3, 5}, {36, 16}}) {
            CAPTURE(gps);
            CAPTURE(renderers);
            CHECK(by_processes(plan(gps, renderers, 0), transport) == least_machine());
        }
    }
}
