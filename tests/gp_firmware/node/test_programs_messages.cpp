// A frame's way into messages, piece by piece.
#include <doctest/doctest.h>

#include <vector>

#include "gp_firmware/node/programs_messages.hpp"
#include "tests/gp_firmware/render/support.hpp"

using namespace pxpl5;
using namespace pxpl5::test;
namespace schema = bus::schema;

namespace {

struct Sent final : bus::Outbox {
    void send(bus::NodeId to, bus::Payload payload) override {
        receivers.push_back(to);
        payloads.push_back(payload);
    }
    using bus::Outbox::send;
    std::vector<bus::NodeId> receivers;
    std::vector<bus::Payload> payloads;
};

/// Two triangles over four regions of a picture, of three Renderers, the last without any region.
struct Frame {
    Frame() {
        Random random(1);
        const std::vector<Triangle> triangles(
            2, {vertex_at(0, 0, random), vertex_at(4000, 0, random), vertex_at(0, 8000, random)});
        surfaces[5].complete = true;
        surfaces[5].slabs.push_back(slab_of(triangles, 3));
        request.frame = 9;
        request.views = {pixel_camera(256, 256)};
        request.surfaces = {{5, 0, false, SlabChoice::all}};
        request.assignment = {0, 1, 1, 0};
        drawing.begin(request);
        REQUIRE(!drawing.draw(surfaces, 1000));
        messages.begin(request, 4, renderers.size(), drawing);
    }
    gp::Surfaces surfaces;
    gp::FrameRequest request;
    gp::FrameDrawing drawing;
    gp::ProgramsMessages messages;
    std::vector<bus::NodeId> renderers = {50, 51, 52};
};

}  // namespace

TEST_SUITE("gp/node programs") {
    TEST_CASE("pieces of one triangle give the messages that one piece gives") {
        Frame frame, again;
        Sent at_once, in_pieces;
        CHECK_FALSE(frame.messages.send(frame.drawing, 1000, frame.renderers, at_once));
        int pieces = 1;
        while (again.messages.send(again.drawing, 1, again.renderers, in_pieces)) {
            ++pieces;
        }
        CHECK(pieces >= 3);
        CHECK(at_once.receivers == std::vector<bus::NodeId>{50, 51, 52});
        REQUIRE(in_pieces.receivers == at_once.receivers);
        std::size_t words = 0;
        for (std::size_t r = 0; r < 3; ++r) {
            const auto* one =
                schema::GetMessage(at_once.payloads[r].bytes().data())->body_as_RegionPrograms();
            const auto* other =
                schema::GetMessage(in_pieces.payloads[r].bytes().data())->body_as_RegionPrograms();
            REQUIRE(one->regions()->size() == other->regions()->size());
            CHECK(one->frame() == 9);
            CHECK(one->gp() == 4);
            for (std::uint32_t i = 0; i < one->regions()->size(); ++i) {
                const auto* region = one->regions()->Get(i);
                const auto drawn =
                    words_of(frame.drawing.programs(), region->region(), frame.drawing.grid());
                CHECK(std::vector(region->words()->begin(), region->words()->end()) == drawn);
                const auto* piece = other->regions()->Get(i)->words();
                CHECK(std::vector(piece->begin(), piece->end()) == drawn);
                words += drawn.size();
            }
        }
        CHECK(words == frame.drawing.counts().triangles_out * shape::word_count);
        CHECK(words >= 6 * shape::word_count);
    }

    TEST_CASE("a frame that is given up says which Renderers have got theirs") {
        Frame frame;
        Sent sent;
        while (sent.receivers.empty()) {
            CHECK(frame.messages.sent_count() == 0);
            REQUIRE(frame.messages.send(frame.drawing, 1, frame.renderers, sent));
        }
        CHECK(frame.messages.sent_count() == sent.receivers.size());
        frame.messages.drop();
        CHECK(frame.messages.sent_count() == sent.receivers.size());
    }
}
