#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "host/base/error.hpp"
#include "host/surface/atlas/atlas_chart.hpp"

using namespace pxpl5;
using namespace pxpl5::host;

namespace {

constexpr double pi = 3.14159265358979323846;

/// A ball in which the value falls by 1 per mm from 100 at its middle: at isovalue v the surface is
/// a sphere of radius 100 - v.
AtlasContent ball() {
    AtlasContent content;
    content.title = "ball, watertight";
    for (int index = 0; index < 100; ++index) {
        const double r = 100 - index;
        content.rows.push_back({static_cast<double>(index),
                                static_cast<std::uint64_t>(8 * pi * r * r), 4 * pi * r * r,
                                4.0 / 3.0 * pi * r * r * r, 1});
        content.histogram.counts.push_back(static_cast<std::uint64_t>(4 * pi * r * r));
    }
    content.histogram.high = 100;
    content.plateaus = {{24, 26}, {60, 80}};
    return content;
}

const PictureMark& text_of(const AtlasChart& chart, const std::string& text) {
    const auto found = std::find_if(chart.marks.begin(), chart.marks.end(),
                                    [&](const PictureMark& mark) { return mark.text == text; });
    REQUIRE(found != chart.marks.end());
    return *found;
}

/// The four curves: the lines of as many points as there are rows, without what parts them.
std::vector<PictureMark> curves_of(const AtlasChart& chart, std::size_t rows) {
    std::vector<PictureMark> curves;
    for (const PictureMark& mark : chart.marks) {
        if (mark.kind == MarkKind::line && mark.points.size() == rows && mark.color.a == 255) {
            curves.push_back(mark);
        }
    }
    return curves;
}

}  // namespace

TEST_SUITE("host/surface/atlas_chart") {
    TEST_CASE("each curve goes through its values on the axis that its ticks show") {
        const AtlasContent content = ball();
        const AtlasChart chart = atlas_chart(content);
        const std::vector<PictureMark> curves = curves_of(chart, content.rows.size());
        REQUIRE(curves.size() == 4);
        // Area: 1256.6 cm2 at isovalue 0. The ticks 0 and 1,000 lie in the area's panel alone.
        const float y0 = curves[1].points.back().y, y_top = curves[1].points.front().y;
        const float y_tick = text_of(chart, "1,000").points[0].y;
        const double area_0 = 4 * pi * 100, area_99 = 4 * pi / 100;
        const double expected = y0 + (y_tick - y0) * (area_0 - area_99) / (1000 - area_99);
        CHECK(y_top == doctest::Approx(expected).epsilon(1e-4));
        // Isovalue 50 stands above its tick.
        CHECK(curves[0].points[50].x == doctest::Approx(text_of(chart, "50").points[0].x));
    }

    TEST_CASE("a measure of a wide range has a logarithmic axis, and says so") {
        AtlasContent noisy = ball();
        text_of(atlas_chart(noisy), "triangles");
        for (std::size_t row = 0; row < 5; ++row) {
            noisy.rows[row].triangles *= 100;
        }
        const AtlasChart chart = atlas_chart(noisy);
        text_of(chart, "triangles, logarithmic");
        text_of(chart, "area, cm²");
        // On it, equal ratios are equal heights: radii 80, 40, 20 are a factor of 4 apart.
        const std::vector<PictureMark> curves = curves_of(chart, 100);
        const float y80 = curves[0].points[20].y, y40 = curves[0].points[60].y,
                    y20 = curves[0].points[80].y;
        CHECK(y40 - y80 == doctest::Approx(y20 - y40).epsilon(1e-3));
    }

    TEST_CASE("plateaus are numbered above their middle, and units are said") {
        const AtlasChart chart = atlas_chart(ball());
        const std::vector<PictureMark> curves = curves_of(chart, 100);
        // The number, not the tick "1" of the components' axis: it stands above all curves.
        for (const auto& [number, row] : {std::pair("1", 25), std::pair("2: 60 to 80", 70)}) {
            const bool found =
                std::any_of(chart.marks.begin(), chart.marks.end(), [&](const PictureMark& mark) {
                    return mark.text == number &&
                           std::abs(mark.points[0].x - curves[0].points[row].x) < 0.01F;
                });
            CHECK(found);
        }
        text_of(chart, "area, cm²");
        text_of(chart, "volume, ml");
        text_of(chart, "isovalue");
        AtlasContent ct = ball();
        ct.value_unit = "HU";
        text_of(atlas_chart(ct), "isovalue, HU");
    }

    TEST_CASE("a plateau's label has no more digits than the axis shows") {
        AtlasContent content = ball();
        for (AtlasRow& row : content.rows) {
            row.isovalue *= 40;  // 0 to 3960: a thousandth is 4, so that whole numbers are enough.
        }
        content.plateaus = {{-0.2, 799.6171}, {2400.4999, 3200.51}};
        text_of(atlas_chart(content), "1: 0 to 800");
        text_of(atlas_chart(content), "2: 2,400 to 3,201");
    }

    TEST_CASE("all marks lie within the picture, whatever its shape and the histogram's range") {
        AtlasContent content = ball();
        content.histogram.low = -5000;
        content.histogram.high = 9000;
        content.rows[3].components = 123'456;
        for (const Size size : {Size{560, 560}, Size{1280, 860}, Size{4000, 900}}) {
            const AtlasChart chart = atlas_chart(content, size);
            for (const PictureMark& mark : chart.marks) {
                for (const glm::vec2& p : mark.points) {
                    CHECK(p.x >= 0);
                    CHECK(p.y >= 0);
                    CHECK(p.x <= static_cast<float>(size.width));
                    CHECK(p.y <= static_cast<float>(size.height));
                }
            }
        }
    }

    TEST_CASE("what cannot be drawn is refused with both values") {
        AtlasContent content = ball();
        CHECK_THROWS_WITH_AS(atlas_chart(content, {559, 800}), doctest::Contains("559x800"),
                             RequestError);
        content.rows[4].isovalue = 3;
        CHECK_THROWS_WITH_AS(atlas_chart(content), doctest::Contains("3 follows 3"), RequestError);
        content.rows.resize(1);
        CHECK_THROWS_WITH_AS(atlas_chart(content), doctest::Contains("got 1"), RequestError);
    }

    TEST_CASE("the table has the first and the last row, units, and the plateaus") {
        const std::string text = atlas_text(ball(), 5);
        CHECK(text.find("isovalue  triangles") == 0);
        CHECK(text.find("\n       0    251,327  1256.6  4188.79           1\n") !=
              std::string::npos);
        CHECK(text.find("\n      24    145,166   725.8  1838.78           1        1\n") !=
              std::string::npos);
        CHECK(text.find("\n      99         25     0.1     0.00") != std::string::npos);
        CHECK(text.ends_with("\nplateau 2: isovalue 60 to 80"));
        CHECK(std::count(text.begin(), text.end(), '\n') == 7);
    }
}
