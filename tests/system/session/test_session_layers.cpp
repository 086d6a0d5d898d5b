// Layers of a picture with one transparent surface: requested ahead, and kept.
#include <doctest/doctest.h>

#include <cstdint>
#include <utility>

#include "host/session/session.hpp"
#include "tests/system/error_of.hpp"
#include "tests/system/machine_of.hpp"
#include "tests/system/simulated_machine.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using test::machine_of;

namespace {

constexpr Color ivory{236, 226, 200}, green{20, 200, 20};

/// An opaque surface "s" in a transparent one, "t".
void show_layers(Session& session) {
    session.volumes.load("phantom:sphere");
    session.scene.size = {150, 130};
    session.surfaces.set("s", 0.5, CaseRule::watertight, ivory);
    session.surfaces.set("t", 0.3, CaseRule::watertight, green);
    session.scene.surfaces[1].opacity = 6;
}

bool are_same(const Frames::Layers& a, const Frames::Layers& b) {
    return a.behind.rgba == b.behind.rgba && a.behind.depths == b.behind.depths &&
           a.front.rgba == b.front.rgba && a.front.depths == b.front.depths &&
           a.opacity == b.opacity;
}

/// The layers as a session draws them that has kept none.
Frames::Layers drawn_by_a_new_session(const Scene& scene, const ComponentFilter& parts_of_t = {}) {
    test::SimulatedMachine machine(machine_of(1, 1));
    Session session(machine);
    show_layers(session);
    for (const Surface& each : scene.surfaces) {
        session.surfaces.set(each.name, each.isovalue, CaseRule::watertight, each.color);
    }
    session.surfaces.set_components("t", parts_of_t);
    session.scene.camera = scene.camera;
    session.scene.size = scene.size;
    session.scene.background = scene.background;
    session.scene.clips = scene.clips;
    for (std::size_t i = 0; i < scene.surfaces.size(); ++i) {
        session.scene.surfaces[i].opacity = scene.surfaces[i].opacity;
        session.scene.surfaces[i].rim = scene.surfaces[i].rim;
    }
    return session.frames.draw_layers().value();
}

}  // namespace

TEST_CASE("announced layers are requested with the surface, and drawn once") {
    test::SimulatedMachine machine(machine_of(2, 2));
    Session session(machine);
    show_layers(session);
    const auto announce = [&](double isovalue) {
        session.frames.announce(Frames::Moving{session.scene.size, 0}, true);
        session.surfaces.set("s", isovalue, CaseRule::watertight, ivory);
        REQUIRE(session.frames.has_frame_ahead());
    };
    announce(0.6);
    const Frames::Layers ahead = session.frames.draw_layers().value();
    CHECK_FALSE(session.frames.has_frame_ahead());
    CHECK(are_same(ahead, drawn_by_a_new_session(session.scene)));
    const std::uint32_t after = session.frames.last().frame;
    announce(0.7);
    CHECK(are_same(session.frames.draw_layers().value(), drawn_by_a_new_session(session.scene)));
    CHECK(session.frames.last().frame == after + 1);  // The front is the same.
    // Another picture drops the frames.
    const Picture expected = session.frames.draw();
    announce(0.7);
    CHECK(session.frames.draw().rgba == expected.rgba);
    CHECK_FALSE(session.frames.has_frame_ahead());
    // So does another camera, for which new layers are drawn.
    announce(0.7);
    session.scene.camera.angles.azimuth_deg = 70;
    const Frames::Layers turned = session.frames.draw_layers().value();
    CHECK(turned.front.rgba != ahead.front.rgba);
    CHECK(are_same(turned, drawn_by_a_new_session(session.scene)));
}

TEST_CASE("a layer that would be the same is not drawn again") {
    test::SimulatedMachine machine(machine_of(2, 3));
    Session session(machine);
    show_layers(session);
    std::uint32_t frame = 0;
    /// Draws, and returns how many frames the machine has drawn for it.
    const auto drawn = [&](const ComponentFilter& parts_of_t = {}) {
        const Frames::Layers layers = session.frames.draw_layers().value();
        CHECK(are_same(layers, drawn_by_a_new_session(session.scene, parts_of_t)));
        const std::uint32_t before = std::exchange(frame, session.frames.last().frame);
        return frame - before;
    };
    drawn();
    CHECK(drawn() == 0);
    session.scene.surfaces[1].opacity = 9;
    CHECK(drawn() == 0);  // The host blends.
    session.surfaces.set("s", 0.6, CaseRule::watertight, ivory);
    CHECK(drawn() == 1);
    session.surfaces.set("t", 0.2, CaseRule::watertight, green);
    CHECK(drawn() == 1);
    session.scene.surfaces[1].rim = 8;
    CHECK(drawn() == 1);
    session.scene.background = {9, 8, 7};
    CHECK(drawn() == 2);
    session.scene.camera.angles.elevation_deg = 30;
    CHECK(drawn() == 2);
    session.scene.size = {128, 64};
    CHECK(drawn() == 2);
    // The filter changes what the GPs draw for the same request.
    const ComponentFilter none{.kind = ComponentFilter::Kind::at_least_ml, .least = 1e6};
    session.surfaces.set_components("t", none);
    CHECK(drawn(none) == 2);
    session.surfaces.set_components("t", {});
    CHECK(drawn() == 2);
    // A failed frame may have been drawn without its triangles.
    --session.scene.surfaces[0].revision;
    CHECK_FALSE(test::error_of([&] { session.frames.draw(); }).empty());
    ++session.scene.surfaces[0].revision;
    CHECK(drawn() == 3);  // The failed frame has a number, too.
}

TEST_CASE("no layer is kept from before a restart of the machine") {
    test::SimulatedMachine machine(machine_of(2, 2));
    Session session(machine);
    show_layers(session);
    session.frames.draw_layers();
    const std::uint32_t before = session.frames.last().frame;
    session.frames.forget_content();
    CHECK(are_same(session.frames.draw_layers().value(), drawn_by_a_new_session(session.scene)));
    CHECK(session.frames.last().frame == before + 2);
}

TEST_CASE("no layer is kept for another volume") {
    test::SimulatedMachine machine(machine_of(2, 2));
    Session session(machine);
    show_layers(session);
    session.frames.draw_layers();
    const std::uint32_t before = session.frames.last().frame;
    show_layers(session);
    CHECK(are_same(session.frames.draw_layers().value(), drawn_by_a_new_session(session.scene)));
    CHECK(session.frames.last().frame == before + 2);
}
