// A session on a simulated machine: what one request leaves behind for the next.
#include <doctest/doctest.h>

#include <stdexcept>

#include "host/error.hpp"
#include "host/session.hpp"
#include "tests/system/simulated_machine.hpp"

using namespace pxpl5;
using namespace pxpl5::host;

namespace {

constexpr Colour grey{160, 160, 160};

Topology machine_of(int gps, int renderers, int gp_memory_mib = 64) {
    Topology topology;
    topology.gp.count = gps;
    topology.renderer.count = renderers;
    topology.frame_buffer.count = 1;
    topology.gp_memory_mib = gp_memory_mib;
    topology.seed = 11;
    return topology;
}

std::string error_of(const std::function<void()>& act) {
    try {
        act();
    } catch (const RequestError& error) {
        return error.what();
    }
    return {};
}

}  // namespace

TEST_CASE("an orbit that is broken off leaves no frame and no turned camera behind") {
    test::SimulatedMachine machine(machine_of(2, 2));
    Session session(machine);
    session.load("phantom:sphere");
    session.scene.size = {150, 130};
    session.set_surface("s", 0.5, CaseTable::watertight, grey);
    const Picture before = session.draw();
    CHECK_THROWS_AS(session.orbit(7,
                                  [](int index, const Picture&, const Camera&) {
                                      if (index == 2) {
                                          throw std::runtime_error("the disk is full");
                                      }
                                  }),
                    std::runtime_error);
    CHECK(session.draw().rgba == before.rgba);
    session.scene.size = {64, 64};
    CHECK(session.draw().rgba.size() == 64 * 64);
}

TEST_CASE("a frame asked for too early does not stand in the way of later ones") {
    test::SimulatedMachine machine(machine_of(1, 1));
    Session session(machine);
    CHECK(error_of([&] { session.draw(); }).find("no volume is loaded") == 0);
    CHECK(error_of([&] {
              session.orbit(3, [](int, const Picture&, const Camera&) {});
          }).find("no volume") == 0);
    session.load("phantom:sphere");
    CHECK(session.draw().rgba.size() == 512 * 512);
}

TEST_CASE("when all GPs refuse a volume, the next volume is not blamed for it") {
    test::SimulatedMachine machine(machine_of(4, 1, 1));
    Session session(machine);
    const std::string error = error_of([&] { session.load("phantom:head"); });
    CHECK(error.find("phantom:head") == 0);
    CHECK(error.find("GPs") != std::string::npos);
    CHECK(!session.has_volume());
    CHECK_NOTHROW(session.load("phantom:sphere"));
    CHECK_NOTHROW(session.set_surface("s", 0.5, CaseTable::watertight, grey));
    CHECK(session.draw().rgba.size() == 512 * 512);
}

TEST_CASE("a surface that no GP has room for is gone, and the others stay") {
    test::SimulatedMachine machine(machine_of(2, 1, 6));
    Session session(machine);
    session.load("phantom:letters");
    std::string error;
    int held = 0;
    for (; held < 16 && error.empty(); ++held) {
        error = error_of([&] {
            session.set_surface("s" + std::to_string(held), 100 + held, CaseTable::watertight,
                                grey);
        });
    }
    REQUIRE(!error.empty());
    CHECK(error.find("GPs") != std::string::npos);
    CHECK(session.scene.surfaces.size() == static_cast<std::size_t>(held - 1));
    CHECK_NOTHROW(session.draw());
    CHECK_NOTHROW(session.mesh_digest("s0"));
}

TEST_CASE("the newest isovalue of a surface is what is drawn") {
    test::SimulatedMachine machine(machine_of(3, 2));
    Session session(machine);
    session.load("phantom:sphere");
    session.scene.size = {100, 100};
    session.set_surface("s", 0.5, CaseTable::watertight, grey);
    const Picture large = session.draw();
    session.set_surface("s", 1500.5, CaseTable::watertight, grey);
    CHECK(session.draw().rgba != large.rgba);
    session.set_surface("s", 0.5, CaseTable::watertight, grey);
    CHECK(session.draw().rgba == large.rgba);
}
