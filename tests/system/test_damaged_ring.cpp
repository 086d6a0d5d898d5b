// A message is lost, repeated or damaged somewhere in a run: never a wrong picture, never a crash.
#include <doctest/doctest.h>

#include "host/base/error.hpp"
#include "host/session/session.hpp"
#include "tests/system/simulated_machine.hpp"

using namespace pxpl5;
using namespace pxpl5::host;

namespace {

/// Far more than the messages of the short run below.
constexpr std::uint64_t messages_tried = 90;

Topology small_machine() {
    Topology topology;
    topology.gp.count = 2;
    topology.renderer.count = 2;
    topology.frame_buffer.count = 1;
    topology.seed = 7;
    return topology;
}

struct Outcome {
    std::vector<std::uint32_t> picture;  ///< Empty if the run ended with an error.
    std::string error;
};

Outcome run_with(const bus::SimulatedFault& fault) {
    try {
        test::SimulatedMachine machine(small_machine(), fault);
        Session session(machine);
        session.volumes.load("phantom:sphere");
        session.scene.size = {160, 140};
        session.surfaces.set("s", 0.5, CaseRule::watertight, {200, 180, 160});
        session.frames.draw();
        return {session.frames.draw().rgba.copy(), {}};
    } catch (const RequestError& error) {
        return {{}, error.what()};
    } catch (const MachineError& error) {
        return {{}, error.what()};
    }
}

}  // namespace

TEST_CASE("a damaged message ends in an error that says so, or changes nothing") {
    const Outcome sound = run_with({});
    REQUIRE(!sound.picture.empty());
    for (const bus::Damage damage :
         {bus::Damage::drop, bus::Damage::repeat, bus::Damage::flip_bit}) {
        int errors = 0, noticed_by_number = 0;
        for (std::uint64_t message = 0; message < messages_tried; ++message) {
            const Outcome outcome = run_with({damage, message});
            CAPTURE(static_cast<int>(damage));
            CAPTURE(message);
            CHECK((outcome.error.empty() ? outcome.picture == sound.picture
                                         : outcome.picture.empty()));
            errors += outcome.error.empty() ? 0 : 1;
            noticed_by_number += outcome.error.find(" was due") == std::string::npos ? 0 : 1;
        }
        CHECK_MESSAGE(errors >= 10, "damage ", static_cast<int>(damage));
        // A message whose fellows follow is missed by its number, before anything else goes wrong.
        const bool is_numbering = damage != bus::Damage::flip_bit;
        CHECK_MESSAGE((noticed_by_number >= 10) == is_numbering, noticed_by_number, " of damage ",
                      static_cast<int>(damage));
    }
}

TEST_CASE("a sweep with a refused message leaves a machine that works") {
    // From the message with which the sweep begins, about, to its end.
    constexpr std::uint64_t first = 40, last = 170;
    int failed = 0, kept = 0;
    for (std::uint64_t message = first; message < last; ++message) {
        CAPTURE(message);
        test::SimulatedMachine machine(small_machine(), {bus::Damage::flip_bit, message});
        Session session(machine);
        const auto set_and_draw = [&session](const char* name) {
            session.surfaces.set(name, 0.5, CaseRule::watertight, {200, 180, 160});
            session.frames.draw();
        };
        bool sweeps = false;
        try {
            session.volumes.load("phantom:sphere");
            session.scene.size = {100, 100};
            set_and_draw("s");
            sweeps = true;
            session.surfaces.sweep("s", std::vector<double>{0.5, 100.5, 200.5},
                                   [](int, const Picture&, const SurfaceReport&) {});
        } catch (const RequestError&) {
            if (!sweeps) {
                continue;
            }
            ++failed;
            kept += session.surfaces.find("s") ? 1 : 0;
            // What was lost may be told once more, by the frame that comes behind it.
            try {
                set_and_draw("t");
            } catch (const RequestError&) {
            }
            CHECK_NOTHROW(set_and_draw("t"));
        } catch (const MachineError&) {  // The host itself was sent what it cannot trust.
        }
    }
    CHECK(failed >= 10);
    CHECK(kept >= 1);
}
