#include <doctest/doctest.h>

#include <string>
#include <variant>
#include <vector>

#include "host/report/scaling.hpp"
#include "tests/golden.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using namespace pxpl5::host::report;
using timing::Unit;

namespace {

/// Builds scale as GPs do; frames until 8 GPs, where the Renderers take over.
ScalingReport hand_made() {
    ScalingRow row{"pelvis/skin", {}, {}};
    double build_ms = 6400, frames = 1;
    for (std::uint32_t count = 1; count <= 64; count *= 2) {
        row.gps.points.push_back(
            {count, build_ms, frames, Unit::gp, count <= 8 ? Unit::gp : Unit::renderer});
        row.renderers.points.push_back({count, 200, 8, Unit::gp, Unit::frame_buffer});
        build_ms /= 2;
        frames *= count < 8 ? 2 : 1.01;
    }
    return {36, 16, {row}};
}

std::int64_t count(const Fields& fields, const std::string& name) {
    for (const Field& field : fields) {
        if (field.name == name) {
            return std::get<std::int64_t>(field.value);
        }
    }
    FAIL("no field " << name);
    return 0;
}

}  // namespace

TEST_SUITE("host/report/scaling") {
    TEST_CASE("it saturates at the first point from which doubling gains less than 5 %") {
        CHECK(saturation(std::vector<double>{1, 2, 4, 8}) == std::nullopt);
        CHECK(saturation(std::vector<double>{1, 2, 2.09, 4}) == 1);
        CHECK(saturation(std::vector<double>{1, 1.06, 1.12, 1.1}) == 2);
        CHECK(saturation(std::vector<double>{1, 1}) == 0);
        CHECK(saturation(std::vector<double>{1}) == std::nullopt);
    }

    TEST_CASE("speed-up is over the first point") {
        const ScalingReport report = hand_made();
        CHECK(report.rows[0].gps.build_speed_up() == std::vector<double>{1, 2, 4, 8, 16, 32, 64});
        CHECK(report.rows[0].gps.frames_speed_up().at(3) == 8);
        CHECK(report.rows[0].renderers.frames_speed_up().at(6) == 1);
    }

    TEST_CASE("tables say times, speed-up and limits, and where more nodes do not help") {
        test::check_golden("scaling_table.txt", text_of(hand_made()),
                           "ctest --preset release -R host_report");
    }

    TEST_CASE("each machine that was modelled is a line of fields") {
        const std::vector<Fields> lines = fields_of(hand_made());
        REQUIRE(lines.size() == 14);
        CHECK(count(lines[2], "gps") == 4);
        CHECK(count(lines[2], "renderers") == 16);
        CHECK(count(lines[13], "gps") == 36);
        CHECK(count(lines[13], "renderers") == 64);
        CHECK(csv_line(lines[3]) == "\"pelvis/skin\",8,16,800,8,\"GP\",8,8,\"GP\"\n");
    }

    TEST_CASE("plots have a line for each row, its saturation ringed, and the ideal") {
        const std::vector<host::Plot> plots = plots_of(hand_made());
        REQUIRE(plots.size() == 3);
        const auto& frames = std::get<host::LinePlot>(plots[1]);
        REQUIRE(frames.lines.size() == 2);
        CHECK(frames.lines[0].ringed == 3);
        CHECK(frames.lines[0].points[3].x == 8);
        CHECK(frames.lines[0].points[3].y == 8);
        CHECK(frames.lines[1].points[6].y == 64);
        CHECK(frames.lines[1].name == "linear");
        CHECK(frames.note == "Circle: doubling from here gains less than 5 %.");
        CHECK(std::get<host::LinePlot>(plots[0]).lines[0].ringed == std::nullopt);
        CHECK(std::get<host::LinePlot>(plots[0]).note.empty());
    }
}
