// `why` beside a direct computation: the pixel's ray against every triangle of the surface.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "host/base/error.hpp"
#include "host/inspect/step/region_stepper.hpp"
#include "host/phantom/phantom.hpp"
#include "isa/disassemble.hpp"
#include "tests/host/inspect/ray_check.hpp"

using namespace pxpl5;
using namespace pxpl5::test;

TEST_SUITE("why") {
    TEST_CASE("a covered pixel's cell is the one that its ray meets first") {
        RecordedSurface recorded(host::make_phantom("phantom:torus"), 3, 2);
        recorded.add_surface(30000.5);
        recorded.draw({{30, 25}, 1.0}, 300, 200);
        check_pixels(recorded, 30000.5, 200);
    }
    TEST_CASE("in the second of two views, too") {
        RecordedSurface recorded(host::make_phantom("phantom:torus"), 2, 2);
        recorded.add_surface(30000.5);
        recorded.draw({{30, 25}, 1.0}, 300, 200, [](bus::schema::DrawFrameT& draw) {
            auto second = std::make_unique<bus::schema::ViewT>(*draw.views[0]);
            auto shifted = second->voxel_to_eye->m();
            std::array<double, 16> m{};
            std::copy(shifted->begin(), shifted->end(), m.begin());
            m[12] += 5;  // The other eye: 5 mm to the left.
            second->voxel_to_eye = std::make_unique<bus::schema::Matrix>(flatbuffers::make_span(m));
            draw.views.push_back(std::move(second));
        });
        check_pixels(recorded, 30000.5, 30, 200);
    }
    TEST_CASE("a stepper that is sent to where the pixel was written stands before that store") {
        RecordedSurface recorded(host::make_phantom("phantom:torus"), 3, 2);
        recorded.add_surface(30000.5);
        recorded.draw({{0, 90}, 1.0}, 200, 200);
        const inspect::RecordedRun run = recorded.run();
        inspect::FrameInquiry frame(run, std::nullopt);
        const inspect::PixelHistory history = inspect::why(frame, 100, 42).history;
        const inspect::RecordedFrame again = run.frame(0);
        inspect::RegionStepper stepper(again.regions.at(history.place.number).plan);
        REQUIRE(history.shown() != nullptr);
        std::vector<inspect::PixelWrite> writes = history.prologue;
        std::ranges::copy(history.shown()->writes, std::back_inserter(writes));
        std::ranges::copy(history.end_of_region, std::back_inserter(writes));
        for (const inspect::PixelWrite& write : writes) {
            stepper.seek(write.at);
            CHECK(stepper.walk().at() == write.address);
            CHECK(isa::disassemble(stepper.walk().next(), stepper.walk().coefficients()) ==
                  write.text);
        }
    }
    TEST_CASE("the answer begins with a sentence for people, and is one object for programs") {
        RecordedSurface recorded(host::make_phantom("phantom:torus"), 3, 2);
        recorded.add_surface(30000.5);
        recorded.draw({{0, 90}, 1.0}, 200, 200);  // From above: the ring is round, its middle open.
        const inspect::RecordedRun run = recorded.run();
        inspect::FrameInquiry frame(run, std::nullopt);
        const inspect::WhyFinding ring = inspect::why(frame, 100, 42);
        REQUIRE(ring.shown() != nullptr);
        const TriangleName& n = ring.shown()->cell.value().name;
        const host::Reply reply = inspect::answer_of(ring).reply();
        CHECK(reply.text.starts_with(fmt::format(
            "Pixel (100, 42) of frame 0 shows surface 0 (isovalue 30000.5): triangle {} of cell "
            "({}, {}, {}), which gp-{} sent, the nearest of",
            n.triangle, n.i, n.j, n.k, n.k % 3)));
        const std::string json = host::json_text(reply.fields);
        CHECK(json.find("\"table\":\"watertight\"") != std::string::npos);
        CHECK(json.find(fmt::format("\"cell\":[{}.0,{}.0,{}.0]", n.i, n.j, n.k)) !=
              std::string::npos);

        const std::string hole = inspect::answer_of(inspect::why(frame, 100, 100)).text();
        CHECK(hole.starts_with("Pixel (100, 100) of frame 0 shows the background, #010203: none "));
        CHECK_THROWS_AS(inspect::why(frame, 200, 0), host::RequestError);
        CHECK_THROWS_AS(inspect::parse_cell("1,2"), host::RequestError);
        CHECK_THROWS_AS(inspect::parse_cell("1,2,3,"), host::RequestError);
        CHECK_THROWS_WITH(
            inspect::why_not(frame, 1, 1, {std::array{79, 0, 0}, {}, {}}),
            "cell (79, 0, 0) is outside of the volume, which has 79 x 63 x 31 cells, counted "
            "from 0");
    }
}
