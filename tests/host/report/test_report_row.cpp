#include <doctest/doctest.h>

#include <string>
#include <variant>
#include <vector>

#include "host/report/report_row.hpp"
#include "tests/golden.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using namespace pxpl5::host::report;
using timing::Unit;

namespace {

std::vector<ReportRow> rows() {
    ReportRow skin{"pelvis/skin", "phantom:pelvis", false, 41708, 41716, {}, {}, "", ""};
    skin.build_ms = {409, 419.4, 5.25, Unit::gp, 0.97};
    skin.frames_per_s = {20, 23.5, 61.04, Unit::gp, 0.99};
    skin.frames_reason = "GP 3 is busiest";
    ReportRow head{
        "mr-head/skin", "data/mr/head_96x96x109.mha", true, 269720, 269544, {}, {}, "", ""};
    head.build_ms = {591, 400, 30.5, Unit::gp, 0.9};
    head.build_reason = "GP 0 is busiest";
    head.frames_per_s = {3, 2.6, 9.96, Unit::waiting, 0.8};
    return {skin, head};
}

double number(const Fields& fields, const std::string& name) {
    for (const Field& field : fields) {
        if (field.name == name) {
            return std::get<double>(field.value);
        }
    }
    FAIL("no field " << name);
    return 0;
}

}  // namespace

TEST_SUITE("host/report/report_row") {
    TEST_CASE("an error is the modelled figure's distance from the paper's") {
        CHECK(Figure{400, 500, 0, {}, 0}.error_percent() == doctest::Approx(25));
        CHECK(Figure{20, 17, 0, {}, 0}.error_percent() == doctest::Approx(-15));
    }

    TEST_CASE("a figure near its bound is within, one beyond is not") {
        ReportRow row = rows()[0];
        row.build_ms.modelled = 409 * 1.199;
        CHECK(row.build_within());
        row.build_ms.modelled = 409 * 0.799;
        CHECK(!row.build_within());
        row.frames_per_s.modelled = 17.001;
        CHECK(row.frames_within());
        row.frames_per_s.modelled = 23.001;
        CHECK(!row.frames_within());
    }

    TEST_CASE("the table has a line for each row, and a sentence for each figure beyond") {
        test::check_golden("paper_table.txt", table_of(rows()),
                           "ctest --preset release -R host_report");
    }

    TEST_CASE("lines of the table are not too wide") {
        std::vector<ReportRow> wide = rows();
        wide[0].name = "us-spine/spine";
        wide[0].held_back = true;
        wide[0].frames_per_s.limit = Unit::frame_buffer;
        std::string table = table_of({wide[0]});
        table.resize(table.find("us-spine/spine: "));
        std::size_t begin = 0;
        for (std::size_t end = 0; (end = table.find('\n', begin)) != std::string::npos;
             begin = end + 1) {
            CHECK(end - begin <= 120);
        }
        CHECK(begin == table.size());
    }

    TEST_CASE("what columns mean is told") {
        const std::string text = text_of(Footnote{"36 GPs", "2 GPs"});
        CHECK(text.find("modelled: 36 GPs;") != std::string::npos);
        CHECK(text.find("limit: what was busy for 90 % of") != std::string::npos);
        CHECK(text.find("pictures of 1280x1024") != std::string::npos);
        CHECK(text.find("wall: wall time here, 2 GPs, pictures of 512x512") != std::string::npos);
    }

    TEST_CASE("a row's fields have all figures") {
        const Fields fields = fields_of(rows()[0]);
        CHECK(csv_heading(fields) ==
              "row,source,held_back,paper_triangles,triangles,paper_build_ms,modelled_build_ms,"
              "build_ms_error_percent,build_ms_within,build_ms_limit,build_ms_limit_share,build_ms_"
              "reason,"
              "wall_build_ms,paper_frames_per_s,modelled_frames_per_s,frames_per_s_error_percent,"
              "frames_per_s_within,frames_per_s_limit,frames_per_s_limit_share,"
              "frames_per_s_reason,"
              "wall_frames_per_s\n");
        CHECK(number(fields, "modelled_build_ms") == 419.4);
        CHECK(number(fields, "frames_per_s_error_percent") == doctest::Approx(17.5));
        CHECK(
            csv_line(fields).starts_with("\"pelvis/skin\",\"phantom:pelvis\",false,41708,41716,"
                                         "409,419.4,"));
        CHECK(csv_line(fields).ends_with(",false,\"GP\",0.99,\"GP 3 is busiest\",61.04\n"));
    }

    TEST_CASE("the picture has bars of paper, model and wall for each row") {
        const std::vector<host::Plot> plots = plots_of(rows());
        REQUIRE(plots.size() == 2);
        const auto& build = std::get<host::BarPlot>(plots[0]);
        CHECK(build.groups == std::vector<std::string>{"pelvis skin", "mr-head skin\u00a0*"});
        REQUIRE(build.series.size() == 3);
        CHECK(build.series[0].values[1] == 591);
        CHECK(build.series[1].values[0] == 419.4);
        CHECK(build.series[2].values[1] == 30.5);
        CHECK(std::get<host::BarPlot>(plots[1]).series[1].values[1] == 2.6);
    }
}
