#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <regex>
#include <string>
#include <vector>

#include "host/base/error.hpp"
#include "host/timing/plot.hpp"
#include "tests/host/timing/xml.hpp"

using namespace pxpl5::host;
using namespace pxpl5::host::timing;
using pxpl5::test::xml_fault;

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

std::string svg(const Plot& plot) {
    return svg_of({&plot, 1});
}

/// All numbers of an attribute of an element.
std::vector<double> numbers(const std::string& text, const std::string& element,
                            const std::string& attribute) {
    const std::regex pattern("<" + element + "[^>]* " + attribute + "=\"(-?[0-9.]+)\"");
    std::vector<double> found;
    for (std::sregex_iterator at(text.begin(), text.end(), pattern), end; at != end; ++at) {
        found.push_back(std::stod((*at)[1]));
    }
    return found;
}

/// "x,y" pairs of the first polyline that is not part of a legend.
std::vector<PlotPoint> curve(const std::string& text) {
    const std::regex pattern("<polyline points=\"([^\"]+)\"");
    std::smatch match;
    REQUIRE(std::regex_search(text, match, pattern));
    const std::string list = match[1];
    const std::regex pair("([0-9.]+),([0-9.]+)");
    std::vector<PlotPoint> points;
    for (std::sregex_iterator at(list.begin(), list.end(), pair), end; at != end; ++at) {
        points.push_back({std::stod((*at)[1]), std::stod((*at)[2])});
    }
    return points;
}

std::string refusal(const Plot& plot) {
    try {
        svg(plot);
    } catch (const RequestError& error) {
        CHECK(error.code == ExitCode::bad_data);
        return error.what();
    }
    return "not refused";
}

bool has(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

}  // namespace

TEST_SUITE("host/timing/plot") {
    TEST_CASE("each kind of plot is a well-formed document") {
        const std::vector<Plot> all{doubling(), bars(), changes()};
        for (const std::size_t columns : {1U, 2U, 5U}) {
            CHECK(xml_fault(svg_of(all, columns)) == "");
        }
        CHECK(xml_fault("<a><b></a></b>") != "");
        CHECK(xml_fault("<a b=1/>") != "");
        CHECK(xml_fault("<a/>&") != "");
    }

    TEST_CASE("names with marks of XML are escaped") {
        LinePlot plot = doubling();
        plot.title = "a < b & \"c\" > 'd'\x01";
        plot.lines[0].name = "<script>";
        const std::string text = svg(plot);
        CHECK(xml_fault(text) == "");
        CHECK(has(text, ">a &lt; b &amp; &quot;c&quot; &gt; &apos;d&apos;<"));
        CHECK(has(text, "&lt;script&gt;"));
    }

    TEST_CASE("doubling both is one step along both axes of octaves") {
        const std::vector<PlotPoint> at = curve(svg(doubling()));
        REQUIRE(at.size() == 3);
        CHECK(at[1].x - at[0].x == doctest::Approx(at[2].x - at[1].x));
        CHECK(at[0].y - at[1].y == doctest::Approx(at[1].y - at[2].y));
        CHECK(at[0].y > at[1].y);
    }

    TEST_CASE("a linear axis begins at 0, and shows values in proportion") {
        LinePlot plot = doubling();
        plot.x.scale = plot.y.scale = PlotScale::linear;
        const std::string text = svg(plot);
        const std::vector<PlotPoint> at = curve(text);
        REQUIRE(at.size() == 3);
        CHECK(at[2].x - at[1].x == doctest::Approx(2 * (at[1].x - at[0].x)).epsilon(0.001));
        CHECK(has(text, ">0<"));
    }

    TEST_CASE("a ring is around the point that is told apart") {
        const std::string text = svg(doubling());
        const std::vector<PlotPoint> at = curve(text);
        const std::vector<double> x = numbers(text, "circle", "cx");
        const std::vector<double> radius = numbers(text, "circle", "r");
        REQUIRE(x.size() == 5);  // Three points, the ring, the legend's.
        CHECK(x[3] == at[2].x);
        CHECK(radius[3] > radius[2]);
    }

    TEST_CASE("bars are as high as their values, with the value over them") {
        const std::string text = svg(bars());
        std::vector<double> heights = numbers(text, "rect", "height");
        REQUIRE(heights.size() == 6);  // Background, two of the legend, three bars.
        CHECK(heights[5] / heights[3] == doctest::Approx(591.0 / 409).epsilon(0.001));
        CHECK(heights[4] / heights[3] == doctest::Approx(4.0 / 409).epsilon(0.01));
        CHECK(has(text, ">409<"));
        CHECK(has(text, ">591<"));
    }

    TEST_CASE("changes go to either side of 0") {
        const std::string text = svg(changes());
        const std::vector<double> x = numbers(text, "rect", "x");
        const std::vector<double> width = numbers(text, "rect", "width");
        REQUIRE(x.size() == 4);  // Two of the legend, two bars.
        CHECK(x[2] + width[3] == doctest::Approx(x[3]).epsilon(0.001));
        CHECK(width[4] / width[3] == doctest::Approx(18.0 / 20).epsilon(0.001));
        CHECK(has(text, ">-20<"));
        CHECK(has(text, ">+18<"));
    }

    TEST_CASE("everything lies within the picture, on white") {
        const std::vector<Plot> all{doubling(), bars(), changes()};
        for (const Plot& plot : all) {
            const std::string text = svg(plot);
            const double width = numbers(text, "svg", "width").at(0);
            const double height = numbers(text, "svg", "height").at(0);
            CHECK(has(text, "fill=\"#ffffff\""));
            for (const char* name : {"x", "x1", "x2", "cx"}) {
                for (const char* element : {"text", "line", "rect", "circle"}) {
                    for (const double x : numbers(text, element, name)) {
                        CHECK(x >= 0);
                        CHECK(x <= width);
                    }
                }
            }
            for (const char* name : {"y", "y1", "y2", "cy"}) {
                for (const char* element : {"text", "line", "rect", "circle"}) {
                    for (const double y : numbers(text, element, name)) {
                        CHECK(y >= 0);
                        CHECK(y <= height);
                    }
                }
            }
        }
    }

    TEST_CASE("numbers that are none are refused by name") {
        LinePlot line = doubling();
        line.lines[0].points[1].y = std::numeric_limits<double>::quiet_NaN();
        CHECK(refusal(line) ==
              "plot 'speed' cannot be drawn: point 1 of line 'skin' at frames/s is nan, no finite "
              "number");
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
        CHECK_THROWS_AS(svg_of({}), RequestError);
        const std::vector<Plot> one{bars()};
        CHECK_THROWS_AS(svg_of(one, 0), RequestError);
    }

    TEST_CASE("values of 0 alone are drawn") {
        CHECK(xml_fault(svg(BarPlot{"", "", "", {"a"}, {{"b", {0}}}})) == "");
        CHECK(xml_fault(svg(ChangePlot{"", "", "", "", "", {{"a", 0, 0}}})) == "");
        CHECK(xml_fault(svg(LinePlot{"", "", {}, {}, {{"", {{0, 0}}, 0, false, {}}}})) == "");
    }
}
