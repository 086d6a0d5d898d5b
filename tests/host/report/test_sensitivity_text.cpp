#include <doctest/doctest.h>

#include <string>
#include <variant>
#include <vector>

#include "host/report/fit_text.hpp"
#include "host/report/sensitivity_text.hpp"
#include "tests/golden.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using namespace pxpl5::host::report;
using timing::Fit;
using timing::Parameter;
using timing::Sensitivity;
using timing::Trial;

namespace {

const Parameter gp_clock{"gp.clock_mhz", "MHz", &timing::Machine::gp_clock_mhz, 1, 1000, false};
const Parameter ports{
    "frame_buffer.ports", "ports", &timing::Machine::frame_buffer_ports, 1, 8, true};
const Parameter hop{"ring.hop_ns", "ns", &timing::Machine::ring_hop_ns, 0, 1000, false};
const std::vector<std::string> names{"pelvis/skin", "head/skin"};

std::vector<Sensitivity> list() {
    return {{&gp_clock, 40, Trial{32, {{24, -19}, {25, -20}}}, Trial{48, {{-16, 18}, {-17, 15}}}},
            {&ports, 1, {}, Trial{2, {{0, 4}, {0, 0.5}}}},
            {&hop, 50, Trial{40, {{-0.01, 0}, {0, 0}}}, Trial{60, {{0.01, 0}, {0, 0.4}}}}};
}

}  // namespace

TEST_SUITE("host/report/sensitivity_text") {
    TEST_CASE("a table of changes, what does not matter, and the greatest in words") {
        test::check_golden("sensitivity_table.txt", text_of(list(), names),
                           "ctest --preset release -R host_report");
    }

    TEST_CASE("each value that was tried is a line for each row") {
        const std::vector<Fields> lines = fields_of(list(), names);
        REQUIRE(lines.size() == 10);
        CHECK(csv_line(lines[1]) == "\"gp.clock_mhz\",\"MHz\",40,32,\"head/skin\",25,-20\n");
        CHECK(csv_line(lines[4]) == "\"frame_buffer.ports\",\"ports\",1,2,\"pelvis/skin\",0,4\n");
    }

    TEST_CASE("plots have the mean over the rows, the greatest first") {
        const std::vector<host::Plot> plots = plots_of(list());
        REQUIRE(plots.size() == 2);
        const auto& frames = std::get<host::ChangePlot>(plots[1]);
        REQUIRE(frames.changes.size() == 2);  // Less than 0.5 % is no bar.
        CHECK(frames.changes[0].name == "gp.clock_mhz");
        CHECK(frames.changes[0].low == -19.5);
        CHECK(frames.changes[0].high == 16.5);
        CHECK(frames.changes[1].name == "frame_buffer.ports -/1/2");
        CHECK(frames.changes[1].low == 0);
    }

    TEST_CASE("a fit is told beside the file's values, with what it used") {
        std::vector<timing::PaperCase> cases(2);
        cases[1].row.held_back = true;
        const Fit fit{{}, {{&gp_clock, 40, 42}}, 1, 0.0953101798, 17};
        CHECK(
            text_of(fit, cases, names) ==
            "fit: used pelvis/skin; held back head/skin\n"
            "parameter     unit  in the file  fits best  difference, %\n"
            "gp.clock_mhz  MHz            40         42          +5.00\n"
            "deviation of what was used, root of the mean square: 10.0 %; 17 runs of the model\n");
        CHECK(json_text(fields_of(fit)) ==
              R"({"values":[{"parameter":"gp.clock_mhz","unit":"MHz","in_file":40.0,)"
              R"("fitted":42.0}],"rows_used":1,"deviation":0.0953101798,"runs":17})");
    }
}
