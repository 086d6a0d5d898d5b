#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "host/io/picture/draw_marks.hpp"
#include "tests/host/io/xml.hpp"

using namespace pxpl5::host;
using namespace pxpl5::host::io;

namespace {

constexpr int side = 200;
constexpr MarkColor white{255, 255, 255, 255};

using Rgba = std::array<int, 4>;

Rgba at(const std::vector<std::uint8_t>& rgba, int x, int y, int width = side) {
    const auto first = 4 * static_cast<std::size_t>(y * width + x);
    return {rgba[first], rgba[first + 1], rgba[first + 2], rgba[first + 3]};
}

std::vector<std::uint8_t> gray_picture(std::uint8_t gray, std::uint8_t alpha = 255) {
    std::vector<std::uint8_t> rgba;
    for (int pixel = 0; pixel < side * side; ++pixel) {
        rgba.insert(rgba.end(), {gray, gray, gray, alpha});
    }
    return rgba;
}

std::vector<std::uint8_t> drawn(const std::vector<PictureMark>& marks,
                                std::vector<std::uint8_t> rgba) {
    lay_over(draw_marks(marks, side, side), rgba);
    return rgba;
}

/// The box in which the picture differs from `gray`. Right and bottom are exclusive.
struct Extent {
    int left = side, top = side, right = 0, bottom = 0;
};

Extent extent_of(const std::vector<std::uint8_t>& rgba, int gray) {
    Extent extent;
    for (int y = 0; y < side; ++y) {
        for (int x = 0; x < side; ++x) {
            if (at(rgba, x, y) != Rgba{gray, gray, gray, 255}) {
                extent = {std::min(extent.left, x), std::min(extent.top, y),
                          std::max(extent.right, x + 1), std::max(extent.bottom, y + 1)};
            }
        }
    }
    return extent;
}

Extent text_extent(float align_x, float align_y) {
    const PictureMark mark = text_mark({100, 100}, "HHHH", white, {20, align_x, align_y, 0});
    return extent_of(drawn({mark}, gray_picture(60)), 60);
}

}  // namespace

TEST_SUITE("host/io/draw_marks") {
    TEST_CASE("an area covers its pixels whole, and the edge by its share") {
        const auto rgba =
            drawn({area_mark({{10, 10}, {20.5F, 10}, {20.5F, 20}, {10, 20}}, {200, 100, 50, 255})},
                  gray_picture(0));
        CHECK(at(rgba, 10, 10) == Rgba{200, 100, 50, 255});
        CHECK(at(rgba, 19, 19) == Rgba{200, 100, 50, 255});
        CHECK(std::abs(at(rgba, 20, 15)[0] - 100) <= 2);
        CHECK(at(rgba, 21, 15) == Rgba{0, 0, 0, 255});
        CHECK(at(rgba, 9, 15) == Rgba{0, 0, 0, 255});
        CHECK(at(rgba, 15, 20) == Rgba{0, 0, 0, 255});
    }

    TEST_CASE("a transparent mark lets what is below shine through, in order of the marks") {
        const auto square = [](MarkColor color) {
            return area_mark({{0, 0}, {9, 0}, {9, 9}, {0, 9}}, color);
        };
        const auto once = drawn({square({255, 255, 255, 51})}, gray_picture(100));
        CHECK(std::abs(at(once, 4, 4)[0] - (51 + 80)) <= 1);
        const auto twice =
            drawn({square({255, 0, 0, 255}), square({0, 0, 255, 255})}, gray_picture(100));
        CHECK(at(twice, 4, 4) == Rgba{0, 0, 255, 255});
    }

    TEST_CASE("a picture's transparency is kept where no mark is, and joined where one is") {
        const auto square = [](MarkColor color) {
            return area_mark({{0, 0}, {9, 0}, {9, 9}, {0, 9}}, color);
        };
        const auto rgba = drawn({square({200, 200, 200, 255})}, gray_picture(40, 0));
        CHECK(at(rgba, 4, 4) == Rgba{200, 200, 200, 255});
        CHECK(at(rgba, 40, 40) == Rgba{40, 40, 40, 0});
        // Half over half: alpha 3/4, of which 2/3 are the mark's.
        const auto half = drawn({square({200, 200, 200, 128})}, gray_picture(80, 128));
        CHECK(std::abs(at(half, 4, 4)[3] - 192) <= 1);
        CHECK(std::abs(at(half, 4, 4)[0] - 160) <= 2);
    }

    TEST_CASE("a text stands at its point as aligned") {
        const Extent left = text_extent(0, 0), middle = text_extent(0.5F, 0.5F),
                     right = text_extent(1, 1);
        CHECK(left.left >= 100);
        CHECK(left.left <= 103);
        CHECK(left.top >= 100);
        CHECK(right.right <= 100);
        CHECK(right.right >= 97);
        CHECK(right.bottom <= 100);
        CHECK(std::abs(middle.left + middle.right - 200) <= 1);
        CHECK(std::abs(middle.top + middle.bottom - 200) <= 2);
        // DejaVu's capitals are 0.729 of the font's size high, an H 0.752 wide.
        CHECK(std::abs(middle.bottom - middle.top - 15) <= 1);
        CHECK(std::abs(middle.right - middle.left - (0.752 * 80 - 4)) <= 2);
    }

    TEST_CASE("light letters have a dark halo, dark ones a light one, and none has no width") {
        const auto extremes = [](MarkColor color, float halo_px) {
            const auto rgba = drawn({text_mark({100, 100}, "H", color, {40, 0.5F, 0.5F, halo_px})},
                                    gray_picture(128));
            int darkest = 255, lightest = 0;
            for (std::size_t index = 0; index < rgba.size(); index += 4) {
                darkest = std::min<int>(darkest, rgba[index]);
                lightest = std::max<int>(lightest, rgba[index]);
            }
            return std::pair(darkest, lightest);
        };
        CHECK(extremes(white, 3).first < 45);
        CHECK(extremes(white, 3).second == 255);
        CHECK(extremes(white, 0).first == 128);
        CHECK(extremes({0, 0, 0, 255}, 3).second > 210);
        CHECK(extremes({0, 0, 0, 255}, 0).second == 128);
    }

    TEST_CASE("the same marks give the same pixels, and what lies outside is cut off") {
        const std::vector<PictureMark> marks = {
            line_mark({{-500, -500}, {90'000, 90'000}}, {10, 200, 30, 200}, 3),
            text_mark({195, 100}, "µ ² Ä 50 mm", white, {14, 0, 0, 2})};
        CHECK(drawn(marks, gray_picture(50)) == drawn(marks, gray_picture(50)));
        CHECK(at(drawn(marks, gray_picture(50)), 20, 20)[1] > 150);
    }

    TEST_CASE("marks that cannot be drawn are refused by number") {
        const auto refused = [](const PictureMark& mark, const char* words) {
            const std::vector<PictureMark> marks = {line_mark({{0, 0}, {1, 1}}, white, 1), mark};
            CHECK_THROWS_WITH_AS(draw_marks(marks, side, side), doctest::Contains(words),
                                 MarkError);
        };
        const float nan = std::numeric_limits<float>::quiet_NaN();
        refused(area_mark({{0, 0}, {1, 1}}, white), "mark 1 (area) has 2 points, needs 3");
        refused(line_mark({{0, 0}, {nan, 1}}, white, 1), "mark 1 (line) has a point at (nan, 1)");
        refused(line_mark({{0, 0}, {2e5F, 1}}, white, 1), "(200000, 1)");
        refused(line_mark({{0, 0}, {1, 1}}, white, -1), "-1 pixels wide");
        refused(text_mark({0, 0}, "big", white, {5000, 0, 0, 0}), "mark 1 (text big) is 5000");
        refused(text_mark({0, 0}, "\xff\xfe", white, {12, 0, 0, 0}), "mark 1 (text");
    }

    TEST_CASE("an SVG is a well-formed document that names its texts") {
        const std::vector<PictureMark> marks = {
            line_mark({{0, 0}, {10, 10}}, white, 1), area_mark({{0, 0}, {9, 0}, {9, 9}}, white),
            text_mark({50, 50}, "a < b & \"c\"", white, {12, 0, 0, 0}),
            text_mark({50, 80}, "<halo>", white, {12, 0, 0, 2})};
        for (const auto& rgba : {gray_picture(90), gray_picture(90, 40)}) {
            const std::string text =
                draw_document(DocumentFormat::svg, {side, side, rgba, marks, "x < y"});
            CHECK(pxpl5::test::xml_fault(text) == "");
            CHECK(text.find("<title>x &lt; y</title>") != std::string::npos);
            CHECK(text.find("a &lt; b &amp; \"c\"\n&lt;halo&gt;\n</desc>") != std::string::npos);
            CHECK(text.find("width=\"200px\"") != std::string::npos);
            CHECK(text.find("<image") == std::string::npos);
        }
        CHECK(pxpl5::test::xml_fault("<a><b></a></b>") != "");
        CHECK(pxpl5::test::xml_fault("<a b=1/>") != "");
        CHECK(pxpl5::test::xml_fault("<a/>&") != "");
    }

    TEST_CASE("a document holds pixels that differ as an image, and marks as shapes") {
        std::vector<std::uint8_t> rgba = gray_picture(90);
        rgba[400] = 7;
        const std::vector<PictureMark> marks = {line_mark({{0, 0}, {10, 10}}, white, 1)};
        const DocumentContent content{side, side, rgba, marks, "d"};
        const std::string svg = draw_document(DocumentFormat::svg, content);
        CHECK(pxpl5::test::xml_fault(svg) == "");
        CHECK(svg.find("<image") != std::string::npos);
        CHECK(svg.find("<path") != std::string::npos);
        const std::string pdf = draw_document(DocumentFormat::pdf, content);
        CHECK(pdf.starts_with("%PDF-"));
        CHECK(pdf.find("/Subtype /Image") != std::string::npos);
        CHECK(pdf.find("150 150") != std::string::npos);  // 200 pixels are 150 points.
        const std::vector<PictureMark> bad = {line_mark({{0, 0}}, white, 1)};
        CHECK_THROWS_AS(draw_document(DocumentFormat::pdf, {side, side, rgba, bad, ""}), MarkError);
    }
}
