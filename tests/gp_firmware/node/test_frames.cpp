// The GP as a node: frames.
#include <doctest/doctest.h>

#include "isa/contract/triangle_shape.hpp"
#include "tests/gp_firmware/node/support.hpp"

using namespace pxpl5;
using namespace pxpl5::test;

namespace {

/// A frame that shows a slice plane alone.
schema::DrawFrameT plane_frame(std::uint8_t axis, std::uint32_t index) {
    schema::DrawFrameT draw = draw_frame(9, 0);
    draw.surfaces.assign(1, schema::SurfaceDraw(plane_surface_id, 0, schema::Rgb(), false,
                                                SlabChoice::all, full_opacity, 0, 0));
    draw.planes.assign(1, schema::SlicePlane(axis, index, 0, 255));
    return draw;
}

}  // namespace

TEST_SUITE("gp/node frames") {
    TEST_CASE("the Master tells every other node that draws to begin, once") {
        const auto gps = run_machine({3, 2}, draw_frame(9, 1));
        std::vector<NodeId> told;
        for (const Sent& s : gps[0]->box.sent) {
            if (const auto* begin = s.as<schema::BeginFrame>()) {
                told.push_back(s.to);
                CHECK(begin->draw()->frame() == 9);
                REQUIRE(begin->assignment()->size() == 6);
                CHECK(begin->assignment()->Get(1) == 1);
            }
        }
        std::ranges::sort(told);
        CHECK(told == std::vector<NodeId>{2, 3, 50, 51, frame_buffer});
    }

    TEST_CASE("costs of the previous frame decide the assignment") {
        schema::DrawFrameT draw = draw_frame(9, 1);
        draw.region_costs = {100, 1, 1, 1, 1, 1};
        const auto gps = run_machine({1, 2}, draw);
        const auto begin = gps[0]->box.of<schema::BeginFrame>();
        REQUIRE(!begin.empty());
        const auto* assignment = begin[0]->assignment();
        CHECK(std::vector<int>(assignment->begin(), assignment->end()) ==
              std::vector<int>{0, 1, 1, 1, 1, 1});
    }

    TEST_CASE("a picture of several samples is refused if its sums have no room") {
        schema::DrawFrameT draw = draw_frame(9, 1);
        draw.width = draw.height = 1450;  // 12 x 12 regions; two Renderers sum 16 samples of 128.
        draw.samples = 16;
        draw.read_back = draw.read_depths = false;
        draw.region_costs.clear();
        std::string refused = "taken";
        try {
            run_machine({1, 2}, draw);
        } catch (const bus::NodeFault& fault) {
            refused = fault.what();
        }
        CHECK(refused ==
              "frame 9: 16 samples of 1450 x 1450 pixels are summed in 144 regions, 2 Renderers "
              "have room for 128; draw a smaller picture, fewer samples, or with more Renderers");
        draw.samples = 4;
        CHECK_FALSE(run_machine({1, 2}, draw)[0]->box.of<schema::BeginFrame>().empty());
    }

    TEST_CASE("each GP sends each Renderer one message, of that Renderer's regions") {
        const auto gps = run_machine({3, 4}, draw_frame(9, 1));
        for (const auto& gp : gps) {
            std::vector<NodeId> to;
            std::size_t words = 0;
            std::uint32_t triangles = 0;
            for (const Sent& s : gp->box.sent) {
                if (const auto* programs = s.as<schema::RegionPrograms>()) {
                    to.push_back(s.to);
                    CHECK(programs->frame() == 9);
                    CHECK(programs->gp() == gp->share.gp_index);
                    triangles = programs->triangles_out();
                    CHECK(programs->triangles_in() > programs->triangles_out() / 6);
                    for (const auto* region : *programs->regions()) {
                        CHECK(region->region() % 4 == s.to - first_renderer);
                        words += region->words()->size();
                    }
                }
            }
            CHECK(to == std::vector<NodeId>{50, 51, 52, 53});
            CHECK(triangles > 0);
            CHECK(words == triangles * isa::triangle::word_count);
        }
    }

    TEST_CASE("streams are the same words for any number of GPs and Renderers") {
        const auto expected = streams(run_machine({1, 1}, draw_frame(9, 1)));
        CHECK(expected.size() > 20);
        for (const MachineSize size : {MachineSize{2, 2}, {3, 5}, {36, 16}}) {
            CHECK(streams(run_machine(size, draw_frame(9, 1))) == expected);
        }
    }

    TEST_CASE("streams of a slice plane are the same words for any number of GPs and Renderers") {
        for (const std::uint8_t axis : {std::uint8_t{0}, std::uint8_t{1}, std::uint8_t{2}}) {
            const auto expected = streams(run_machine({1, 1}, plane_frame(axis, 12)));
            CHECK_FALSE(expected.empty());
            for (const MachineSize size : {MachineSize{2, 2}, {3, 5}, {36, 16}}) {
                CHECK(streams(run_machine(size, plane_frame(axis, 12))) == expected);
            }
        }
    }

    TEST_CASE("a slice plane of no volume, or beyond it, is a fault, and the machine goes on") {
        LoneGp gp({1, 3}, 0);
        gp.receive(bus::pack(plane_frame(2, 3)));
        CHECK(gp.fault_of_work() == "frame 9 shows a slice plane: no volume is stored");
        load(gp);
        gp.receive(bus::pack(plane_frame(1, n)));
        CHECK(gp.fault_of_work() ==
              "frame 9 shows a slice plane: slice 20 across y was requested, but the volume has "
              "slices 0 to 19");
        CHECK(gp.code == schema::FaultCode::bad_input);
        CHECK(gp.box.of<schema::RegionPrograms>().size() == 6);
        gp.receive(bus::pack(plane_frame(1, n - 1)));
        gp.work();
        REQUIRE(gp.box.of<schema::RegionPrograms>().size() == 9);
        CHECK(gp.box.of<schema::RegionPrograms>()[6]->triangles_in() == 2 * (n - 1) * (n - 1));
    }

    TEST_CASE("only while recording, programs tell where each primitive comes from") {
        const MachineSize recorded{2, 2, plenty_bytes, Recording::flight};
        const auto plain = run_machine({2, 2}, draw_frame(9, 1));
        const auto gps = run_machine(recorded, draw_frame(9, 1));
        CHECK(streams(gps) == streams(plain));
        std::size_t primitives = 0;
        for (const auto& gp : gps) {
            for (const auto* programs : gp->box.of<schema::RegionPrograms>()) {
                for (const auto* region : *programs->regions()) {
                    REQUIRE(region->origins() != nullptr);
                    CHECK(region->origins()->size() * isa::triangle::word_count ==
                          region->words()->size());
                    primitives += region->origins()->size();
                    CHECK(region->origins()->Get(0)->inside() != 0);
                }
            }
        }
        CHECK(primitives > 100);
        for (const auto* programs : plain[0]->box.of<schema::RegionPrograms>()) {
            for (const auto* region : *programs->regions()) {
                CHECK(region->origins() == nullptr);
            }
        }
        // What fits does not depend on recording.
        CHECK(gps[0]->box.of<schema::SurfaceBuilt>()[0]->memory_bytes() ==
              plain[0]->box.of<schema::SurfaceBuilt>()[0]->memory_bytes());
    }

    TEST_CASE("a frame waits for the surfaces asked for before it") {
        LoneGp gp({1, 1}, 0);
        load(gp);
        gp.receive(set_surface(4, 1, 100));
        gp.receive(bus::pack(draw_frame(1, 1)));
        CHECK(gp.box.of<schema::RegionPrograms>().empty());
        gp.work();
        REQUIRE(gp.box.of<schema::RegionPrograms>().size() == 1);
        CHECK(gp.box.of<schema::RegionPrograms>()[0]->triangles_in() == [&] {
            std::uint32_t sum = 0;
            for (const auto* s : *gp.box.of<schema::SurfaceBuilt>()[0]->slabs()) {
                sum += s->triangles();
            }
            return sum;
        }());
    }

    TEST_CASE("a frame of what is not held is a fault, and the machine goes on") {
        LoneGp gp({1, 3}, 0);
        load(gp);
        gp.receive(bus::pack(draw_frame(1, 1)));
        CHECK(gp.fault_of_work() == "frame 1 shows surface 4, which is not held");
        CHECK(gp.code == schema::FaultCode::bad_input);
        CHECK(gp.cause.request == bus::Body::BeginFrame);
        CHECK(gp.cause.frame == 1);
        gp.receive(set_surface(4, 2, 100));
        gp.receive(bus::pack(draw_frame(2, 1)));
        CHECK(gp.fault_of_work() == "frame 2 shows revision 1 of surface 4, held is revision 2");
        auto programs = gp.box.of<schema::RegionPrograms>();
        REQUIRE(programs.size() == 6);
        for (const auto* p : programs) {
            CHECK(p->regions()->size() == 0);
        }
        gp.receive(bus::pack(draw_frame(3, 2)));
        gp.work();
        programs = gp.box.of<schema::RegionPrograms>();
        REQUIRE(programs.size() == 9);
        CHECK(programs[6]->frame() == 3);
        CHECK(programs[6]->triangles_out() > 0);
    }
}
