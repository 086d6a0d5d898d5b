// A machine that shows the letters, for tests of pictures as a session sees them.
#pragma once

#include <doctest/doctest.h>

#include <map>
#include <vector>

#include "host/session/session.hpp"
#include "tests/system/simulated_machine.hpp"

namespace pxpl5::test {

using namespace host;
namespace schema = bus::schema;

inline Topology plan(int gps, int renderers, int frame_buffers) {
    Topology topology;
    topology.gp.count = gps;
    topology.renderer.count = renderers;
    topology.frame_buffer.count = frame_buffers;
    topology.seed = 1;
    return topology;
}

using Pixels = std::vector<std::uint32_t>;
constexpr std::uint32_t opaque_black = 0xFF000000;

/// A machine that shows the letters, and notes what it is asked to draw.
struct LettersBench {
    LettersBench(int gps, int renderers, int frame_buffers = 1)
        : machine(plan(gps, renderers, frame_buffers), {},
                  [this](bus::NodeId, const bus::Message& message) {
                      if (const auto* draw = message.as<schema::DrawFrame>()) {
                          draw->UnPackTo(&asked.emplace_back());
                      } else if (const auto* done = message.as<schema::FrameDone>()) {
                          views_done[message.source()] += done->views();
                      }
                  }),
          session(machine) {
        session.volumes.load("phantom:letters");
        session.scene.size = {200, 150};
        session.scene.camera.angles = {30, 20};
        const Volume& volume = session.volumes.volume();
        session.surfaces.set("letters", (volume.minimum + volume.maximum) / 2, CaseRule::watertight,
                             {200, 180, 160});
    }

    /// The picture of one pass alone.
    Pixels alone(schema::DrawFrameT draw, std::uint32_t frame) {
        draw.frame = frame;
        draw.sample = 0;
        draw.samples = 1;
        draw.read_back = true;
        machine.send(machine.gp_ids().front(), bus::pack(draw));
        Pixels pixels;
        machine.pump(
            [&](const bus::Message& message) {
                if (const auto* done = message.as<schema::FrameDone>()) {
                    pixels.assign(done->pixels()->begin(), done->pixels()->end());
                }
            },
            [&] { return !pixels.empty(); });
        return pixels;
    }

    std::vector<schema::DrawFrameT> asked;
    std::map<bus::NodeId, int> views_done;  ///< By frame buffer.
    test::SimulatedMachine machine;
    Session session;
};

}  // namespace pxpl5::test
