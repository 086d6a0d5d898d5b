#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <string>
#include <vector>

#include "host/base/error.hpp"
#include "host/chart/plot.hpp"

using namespace pxpl5;
using namespace pxpl5::host;

namespace {

LinePlot doubling() {
    return {"speed",
            "a note",
            {"GPs", PlotScale::log2},
            {"frames/s", PlotScale::log2},
            {{"skin", {{1, 1}, {2, 2}, {4, 4}}, 0, false, 2}}};
}

BarPlot bars() {
    return {
        "built in", "", "ms", {"pelvis, skin", "head"}, {{"paper", {409, 591}}, {"wall", {4, {}}}}};
}

ChangePlot changes() {
    return {"head", "", "%", "lower", "higher", {{"gp.clock_mhz", -20, 18}}};
}

Chart chart(const Plot& plot) {
    return chart_of({&plot, 1});
}

bool has(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

bool shows(const Chart& chart, const std::string& text) {
    return std::ranges::any_of(chart.marks,
                               [&](const PictureMark& mark) { return mark.text == text; });
}

/// All marks of a kind with so many points.
std::vector<PictureMark> marks(const Chart& chart, MarkKind kind, std::size_t points) {
    std::vector<PictureMark> found;
    std::ranges::copy_if(chart.marks, std::back_inserter(found), [&](const PictureMark& mark) {
        return mark.kind == kind && mark.points.size() == points;
    });
    return found;
}

float height(const PictureMark& area) {
    return area.points[2].y - area.points[1].y;
}

std::string refusal(const Plot& plot) {
    try {
        chart(plot);
    } catch (const RequestError& error) {
        CHECK(error.code == ExitCode::bad_data);
        return error.what();
    }
    return "not refused";
}

}  // namespace

TEST_SUITE("host/chart/plot") {
    TEST_CASE("plots in columns lie beside and below each other") {
        const std::vector<Plot> all{doubling(), bars(), changes()};
        const Chart one = chart_of(all, 1), two = chart_of(all, 2), five = chart_of(all, 5);
        CHECK(one.height > two.height);
        CHECK(two.height > five.height);
        CHECK(one.width < two.width);
        CHECK(two.width < five.width);
        CHECK(one.marks.size() == two.marks.size());
        CHECK(one.marks.size() == five.marks.size());
    }

    TEST_CASE("names go to the marks unchanged, marks of XML among them") {
        LinePlot plot = doubling();
        plot.title = "a < b & \"c\" > 'd'";
        plot.lines[0].name = "<script>";
        CHECK(shows(chart(plot), plot.title));
        CHECK(shows(chart(plot), "<script>"));
    }

    TEST_CASE("doubling both is one step along both axes of octaves") {
        const std::vector<PictureMark> curve = marks(chart(doubling()), MarkKind::line, 3);
        REQUIRE(curve.size() == 1);
        const std::vector<glm::vec2>& at = curve[0].points;
        CHECK(at[1].x - at[0].x == doctest::Approx(at[2].x - at[1].x));
        CHECK(at[0].y - at[1].y == doctest::Approx(at[1].y - at[2].y));
        CHECK(at[0].y > at[1].y);
    }

    TEST_CASE("a linear axis begins at 0, and shows values in proportion") {
        LinePlot plot = doubling();
        plot.x.scale = plot.y.scale = PlotScale::linear;
        const Chart drawing = chart(plot);
        const std::vector<PictureMark> curve = marks(drawing, MarkKind::line, 3);
        REQUIRE(curve.size() == 1);
        const std::vector<glm::vec2>& at = curve[0].points;
        CHECK(at[2].x - at[1].x == doctest::Approx(2 * (at[1].x - at[0].x)).epsilon(0.001));
        CHECK(shows(drawing, "0"));
    }

    TEST_CASE("a ring surrounds the marked point") {
        const Chart drawing = chart(doubling());
        const std::vector<PictureMark> discs = marks(drawing, MarkKind::area, 24);
        const std::vector<PictureMark> rings = marks(drawing, MarkKind::line, 26);
        REQUIRE(discs.size() == 4);  // Three points, the legend's.
        REQUIRE(rings.size() == 1);
        // Corners 0 and 12 are opposite.
        const auto middle = [](const PictureMark& mark) {
            return (mark.points[0].x + mark.points[12].x) / 2;
        };
        CHECK(middle(rings[0]) == doctest::Approx(middle(discs[2])));
        CHECK(rings[0].points[0].x > discs[2].points[0].x);
    }

    TEST_CASE("a dashed line has gaps, and its dashes lie on the line") {
        LinePlot plot = doubling();
        plot.lines[0].dashed = true;
        plot.lines[0].ringed.reset();
        plot.lines[0].name = "";
        const Chart drawing = chart(plot);
        CHECK(marks(drawing, MarkKind::area, 24).empty());
        std::vector<PictureMark> dashes = marks(drawing, MarkKind::line, 2);
        std::erase_if(dashes, [](const PictureMark& mark) { return mark.width_px != 2; });
        REQUIRE(dashes.size() > 10);
        const glm::vec2 first = dashes.front().points[0], last = dashes.back().points[1];
        const float slope = (last.y - first.y) / (last.x - first.x);
        float drawn = 0;
        for (const PictureMark& dash : dashes) {
            drawn += glm::distance(dash.points[0], dash.points[1]);
            for (const glm::vec2& p : dash.points) {
                CHECK(p.y == doctest::Approx(first.y + slope * (p.x - first.x)).epsilon(0.001));
            }
        }
        // Dashes of 6 pixels and gaps of 4.
        CHECK(drawn / glm::distance(first, last) == doctest::Approx(0.6).epsilon(0.03));
    }

    TEST_CASE("bars are as high as their values, with the value over them") {
        const Chart drawing = chart(bars());
        const std::vector<PictureMark> boxes = marks(drawing, MarkKind::area, 4);
        REQUIRE(boxes.size() == 5);  // Two of the legend, three bars.
        CHECK(height(boxes[4]) / height(boxes[2]) == doctest::Approx(591.0 / 409).epsilon(0.001));
        CHECK(height(boxes[3]) / height(boxes[2]) == doctest::Approx(4.0 / 409).epsilon(0.01));
        CHECK(shows(drawing, "409"));
        CHECK(shows(drawing, "591"));
    }

    TEST_CASE("changes go to either side of 0") {
        const Chart drawing = chart(changes());
        const std::vector<PictureMark> boxes = marks(drawing, MarkKind::area, 4);
        REQUIRE(boxes.size() == 4);  // Two of the legend, two bars.
        const std::vector<glm::vec2>&low = boxes[2].points, &high = boxes[3].points;
        CHECK(low[1].x == doctest::Approx(high[0].x));
        CHECK((high[1].x - high[0].x) / (low[1].x - low[0].x) ==
              doctest::Approx(18.0 / 20).epsilon(0.001));
        CHECK(shows(drawing, "-20"));
        CHECK(shows(drawing, "+18"));
    }

    TEST_CASE("everything lies within the chart, texts with their whole width") {
        for (const Plot& plot : std::vector<Plot>{doubling(), bars(), changes()}) {
            const Chart drawing = chart(plot);
            for (const PictureMark& mark : drawing.marks) {
                const double wide = text_width(mark.text, static_cast<double>(mark.height_px));
                for (const glm::vec2& p : mark.points) {
                    const double left =
                        static_cast<double>(p.x) - wide * static_cast<double>(mark.align_x);
                    CAPTURE(mark.text);
                    CHECK(left >= 0);
                    CHECK(left + wide <= drawing.width);
                    CHECK(p.y >= 0);
                    CHECK(static_cast<double>(p.y) <= drawing.height);
                }
            }
        }
    }

    TEST_CASE("a scaled chart has all lengths scaled") {
        const Chart plain = chart(bars()), large = scaled(plain, 2);
        CHECK(large.width == 2 * plain.width);
        REQUIRE(large.marks.size() == plain.marks.size());
        for (std::size_t i = 0; i < plain.marks.size(); ++i) {
            CHECK(large.marks[i].points[0] == 2.0F * plain.marks[i].points[0]);
            CHECK(large.marks[i].height_px == 2 * plain.marks[i].height_px);
            CHECK(large.marks[i].width_px == 2 * plain.marks[i].width_px);
        }
    }

    TEST_CASE("numbers that are none are refused by name") {
        LinePlot line = doubling();
        line.lines[0].points[1].y = std::numeric_limits<double>::quiet_NaN();
        CHECK(refusal(line) ==
              "plot 'speed' cannot be drawn: point 1 of line 'skin' at frames/s is nan, must be a "
              "finite number");
        line.lines[0].points[1].y = 0;
        CHECK(has(refusal(line), "point 1 of line 'skin' at frames/s is 0, not > 0"));
        BarPlot bar = bars();
        bar.series[1].values[0] = std::numeric_limits<double>::infinity();
        CHECK(has(refusal(bar), "'wall' of pelvis, skin is inf"));
        bar.series[1].values[0] = -1;
        CHECK(has(refusal(bar), "'wall' of pelvis, skin is -1, less than 0"));
        ChangePlot change = changes();
        change.changes[0].high = std::numeric_limits<double>::quiet_NaN();
        CHECK(has(refusal(change), "'higher' of gp.clock_mhz is nan"));
    }

    TEST_CASE("plots that show nothing are refused") {
        LinePlot line = doubling();
        line.lines[0].ringed = 3;
        CHECK(has(refusal(line), "line 'skin' has 3 points, but point 3 is ringed"));
        line.lines[0].points.clear();
        CHECK(has(refusal(line), "line 'skin' has no points"));
        line.lines.clear();
        CHECK(has(refusal(line), "it has no lines"));
        BarPlot bar = bars();
        bar.groups.emplace_back("third");
        CHECK(has(refusal(bar), "'paper' has 2 bars, but there are 3 groups"));
        bar.groups.clear();
        CHECK(has(refusal(bar), "it has 0 groups and 2 series"));
        CHECK(has(refusal(ChangePlot{"t", "", "", "", "", {}}), "it has no bars"));
        CHECK_THROWS_AS(chart_of({}), RequestError);
        const std::vector<Plot> one{bars()};
        CHECK_THROWS_AS(chart_of(one, 0), RequestError);
    }

    TEST_CASE("values of 0 alone are drawn") {
        CHECK(shows(chart(BarPlot{"", "", "", {"a"}, {{"b", {0}}}}), "a"));
        CHECK(shows(chart(ChangePlot{"", "", "", "", "", {{"a", 0, 0}}}), "a"));
        CHECK(shows(chart(LinePlot{"", "", {}, {}, {{"", {{0, 0}}, 0, false, {}}}}), "0"));
    }
}
