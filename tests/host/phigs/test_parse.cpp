#include <doctest/doctest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "tests/host/phigs/support.hpp"

using namespace pxpl5;
using namespace pxpl5::test;

namespace {

template <typename Element>
Element only_element(const std::string& text) {
    const phigs::Archive archive = phigs::parse_archive("structure s { " + text + " };", "a.phigs");
    REQUIRE(archive.structures.size() == 1);
    REQUIRE(archive.structures[0].elements.size() == 1);
    REQUIRE(std::holds_alternative<Element>(archive.structures[0].elements[0]));
    return std::get<Element>(archive.structures[0].elements[0]);
}

/// The parser's error for a text whose only line is this element.
std::string element_refusal(const std::string& element) {
    return refusal("structure s {\n" + element + "\n};");
}

std::string of_line_2(int column, const std::string& text) {
    return "a.phigs:2:" + std::to_string(column) + ": " + text;
}

bool is_color(host::Color c, int r, int g, int b) {
    return c.r == r && c.g == g && c.b == b;
}

}  // namespace

TEST_SUITE("phigs/parse") {
    TEST_CASE("structures, posted or not, comments, and blanks of all kinds") {
        const phigs::Archive archive = phigs::parse_archive(
            "/* one */structure a/**/{}\r\n;\tstructure b.2-x posted{execute a;}"
            "/* the * last / one */",
            "a.phigs");
        REQUIRE(archive.structures.size() == 2);
        CHECK(archive.structures[0].name == "a");
        CHECK(!archive.structures[0].posted);
        CHECK(archive.structures[1].name == "b.2-x");
        CHECK(archive.structures[1].posted);
        REQUIRE(archive.structures[1].elements.size() == 1);
        const auto& execute = std::get<phigs::ExecuteElement>(archive.structures[1].elements[0]);
        CHECK(execute.name == "a");
        CHECK(execute.at.line == 2);
        CHECK(execute.at.column == 34);
    }

    TEST_CASE("polygons without and with normals, and numbers of all forms") {
        const auto plain =
            only_element<phigs::PolygonElement>("polygon 3 { 0 0 0; +1.5 -2e1 .5; 1E-3 7. 0; };");
        REQUIRE(plain.corners.size() == 3);
        CHECK(!plain.has_normals);
        CHECK(plain.corners[1].p == glm::dvec3(1.5, -20, 0.5));
        CHECK(plain.corners[2].p == glm::dvec3(0.001, 7, 0));
        const auto smooth = only_element<phigs::PolygonElement>(
            "polygon 3 { 0 0 0 0 0 1; 1 0 0 0 1 0; 0 1 0 1 0 0; }");
        CHECK(smooth.has_normals);
        CHECK(smooth.corners[1].normal == glm::dvec3(0, 1, 0));
    }

    TEST_CASE("polygon5: flags, a color of the polygon's, colors of corners") {
        const auto plain =
            only_element<phigs::PolygonElement>("polygon5 3 3 { 0 0 0; 1 0 0; 0 1 0; };");
        CHECK(!plain.cull_back);
        CHECK(!plain.diffuse);
        const auto full = only_element<phigs::PolygonElement>(
            "polygon5 3 131 diff 1 2 3 255 { 0 0 0 0 0 1 diff 9 8 7 255; 1 0 0 0 0 1; "
            "0 1 0 0 0 1 diff 0 0 255 255; };");
        CHECK(full.cull_back);
        REQUIRE(full.diffuse);
        CHECK(is_color(*full.diffuse, 1, 2, 3));
        REQUIRE(full.corners[0].diffuse);
        CHECK(is_color(*full.corners[0].diffuse, 9, 8, 7));
        CHECK(!full.corners[1].diffuse);
        CHECK(is_color(*full.corners[2].diffuse, 0, 0, 255));
    }

    TEST_CASE("spheres, lines, and structures to execute") {
        const auto sphere = only_element<phigs::SphereElement>("sphere 1 2 3 0.5;");
        CHECK(sphere.center == glm::dvec3(1, 2, 3));
        CHECK(sphere.radius == 0.5);
        const auto line = only_element<phigs::LineElement>("line 2 { 0 0 0; 1 2 3; };");
        REQUIRE(line.points.size() == 2);
        CHECK(line.points[1] == glm::dvec3(1, 2, 3));
        CHECK(only_element<phigs::ExecuteElement>("execute other;").name == "other");
    }

    TEST_CASE("matrices act as their names say") {
        const auto image = [](const std::string& text) {
            const auto e = only_element<phigs::MatrixElement>("matrix Pre " + text + ";");
            return glm::dvec3(e.matrix * glm::dvec4(1, 2, 3, 1));
        };
        CHECK(image("scale 2 3 -4") == glm::dvec3(2, 6, -12));
        CHECK(image("translate 10 20 30") == glm::dvec3(11, 22, 33));
        CHECK(glm::distance(image("rotate x 90"), glm::dvec3(1, -3, 2)) < 1e-12);
        CHECK(glm::distance(image("rotate y 90"), glm::dvec3(3, 2, -1)) < 1e-12);
        CHECK(glm::distance(image("rotate z 90"), glm::dvec3(-2, 1, 3)) < 1e-12);
    }

    TEST_CASE("colors of each kind: front and back, gloss, and the back may be left out") {
        const auto full = only_element<phigs::ColorElement>(
            "color polygon { diff 1 2 3 255  4 5 6 255   spec 7 8 9 20  1 1 1 1 };");
        CHECK(full.kind == phigs::Kind::polygon);
        REQUIRE(full.diffuse);
        CHECK(is_color(full.diffuse->front, 1, 2, 3));
        CHECK(is_color(full.diffuse->back, 4, 5, 6));
        REQUIRE(full.specular);
        CHECK(full.specular->rgb == std::array{7.0, 8.0, 9.0});
        CHECK(full.specular->power == 20);
        const auto front = only_element<phigs::ColorElement>("color sphere { diff 1 2 3 255 };");
        CHECK(front.kind == phigs::Kind::sphere);
        CHECK(is_color(front.diffuse->back, 1, 2, 3));
        CHECK(!front.specular);
        const auto gloss = only_element<phigs::ColorElement>("color line { spec 1 2 3 4; }");
        CHECK(gloss.kind == phigs::Kind::line);
        CHECK(!gloss.diffuse);
    }

    TEST_CASE("what is wrong on the top level is said with its place") {
        CHECK(refusal("sphere 0 0 0 1;") ==
              "a.phigs:1:1: found 'sphere', expected 'structure' at the top level");
        CHECK(refusal("structure") ==
              "a.phigs:1:10: found the end of the file, expected a structure's name");
        CHECK(refusal("structure {") == "a.phigs:1:11: found '{', expected a structure's name");
        CHECK(refusal("structure a Posted {") ==
              "a.phigs:1:13: found 'Posted', expected '{' or 'posted' behind the name");
        CHECK(refusal("structure a posted ;") ==
              "a.phigs:1:20: found ';', expected '{' behind posted");
        CHECK(refusal("structure a {};\nstructure a {};") ==
              "a.phigs:2:11: structure a is there twice");
        CHECK(refusal("structure a {\n  /* no end") ==
              "a.phigs:2:3: this comment has no end: */ is missing");
        CHECK(refusal("structure " + std::string(257, 'n') + " {};") ==
              "a.phigs:1:11: a structure's name has 257 characters, 256 are the most");
    }

    TEST_CASE("what is wrong in an element is said with its place") {
        CHECK(element_refusal("cone 1;") ==
              of_line_2(1,
                        "found 'cone', expected 'polygon', 'polygon5', 'sphere', 'line', "
                        "'color', 'matrix', 'execute' or '}'"));
        CHECK(element_refusal("execute ;") ==
              of_line_2(9, "found ';', expected the name of a structure to execute"));
        CHECK(element_refusal("execute a b") ==
              of_line_2(11, "found 'b', expected ';' behind the name"));
        CHECK(element_refusal("sphere 0 0 x 1;") ==
              of_line_2(12, "found 'x', expected z, a number"));
        CHECK(element_refusal("sphere 0 0 0 -1;") ==
              of_line_2(14, "radius is '-1', allowed are 0 .. 1000000000"));
        CHECK(element_refusal("sphere 0 0 0 0;") == of_line_2(14, "radius is 0, it must be more"));
        CHECK(element_refusal("sphere 1e10 0 0 1;") ==
              of_line_2(8, "x is '1e10', allowed are -1000000000 .. 1000000000"));
        CHECK(element_refusal("sphere 1e999 0 0 1;") ==
              of_line_2(8, "x is '1e999', allowed are -1000000000 .. 1000000000"));
        CHECK(element_refusal("sphere nan 0 0 1;") ==
              of_line_2(8, "found 'nan', expected x, a number"));
        CHECK(element_refusal("sphere 0 0 0 1 2;") ==
              of_line_2(16, "found '2', expected ';' behind a sphere"));
        CHECK(element_refusal("line 1 { 0 0 0; };") ==
              of_line_2(6, "number of points is '1', allowed are 2 .. 65536"));
        CHECK(element_refusal("line 3 { 0 0 0; 1 1 1; };") ==
              of_line_2(8, "2 points are given, 3 were announced"));
        CHECK(element_refusal("line 2 { 0 0 0; 1 1 1; 2 2 2; };") ==
              of_line_2(24, "found '2', expected '}' behind 2 points"));
        CHECK(element_refusal("color cube { };") ==
              of_line_2(7, "found 'cube', expected 'polygon', 'sphere' or 'line' behind color"));
        CHECK(element_refusal("color line { diff 1 2 300 4 };") ==
              of_line_2(23, "blue is '300', allowed are 0 .. 255"));
        CHECK(element_refusal("color line { shade 1 };") ==
              of_line_2(14, "found 'shade', expected 'diff', 'spec' or '}'"));
        CHECK(element_refusal("matrix Post scale 1 1 1;") ==
              of_line_2(8, "found 'Post', expected 'Pre' behind matrix"));
        CHECK(element_refusal("matrix Pre shear 1;") ==
              of_line_2(12, "found 'shear', expected 'scale', 'translate' or 'rotate' behind Pre"));
        CHECK(element_refusal("matrix Pre scale 1 0 1;") ==
              of_line_2(18, "a scale of 0 leaves nothing to draw"));
        CHECK(element_refusal("matrix Pre rotate w 3;") ==
              of_line_2(19, "found 'w', expected an axis: 'x', 'y' or 'z'"));
        CHECK(element_refusal("sphere \x01\xff 0 0 1;") ==
              of_line_2(8, "found '\\x01\\xff', expected x, a number"));
        CHECK(element_refusal("sphere " + std::string(99, 'y') + " 0 0 1;") ==
              of_line_2(8, "found '" + std::string(40, 'y') + "...', expected x, a number"));
    }

    TEST_CASE("what is wrong in a polygon is said with its place") {
        CHECK(element_refusal("polygon 2 { 0 0 0; 1 1 1; };") ==
              of_line_2(9, "number of corners is '2', allowed are 3 .. 1024"));
        CHECK(element_refusal("polygon 3.5 { };") ==
              of_line_2(9, "number of corners is '3.5', not a whole number"));
        CHECK(element_refusal("polygon 4 { 0 0 0; 1 0 0; 0 1 0; };") ==
              of_line_2(11, "3 corners are given, 4 were announced"));
        CHECK(element_refusal("polygon 3 { 0 0 0; 1 0 0; 0 1 0; 1 1 1; };") ==
              of_line_2(34, "found '1', expected '}' behind 3 corners"));
        CHECK(element_refusal("polygon 3 { 0 0 0; 1 0 0 0 0 1; 0 1 0; };") ==
              of_line_2(20, "this corner has a normal, the first one has none"));
        CHECK(element_refusal("polygon 3 { 0 0 0 0 0 1; 1 0 0; 0 1 0; };") ==
              of_line_2(26, "this corner has no normal, the first one has one"));
        CHECK(element_refusal("polygon 3 { 0 0 0 diff 1 2 3 4; };") ==
              of_line_2(19, "found 'diff', expected ';' behind a corner"));
        CHECK(element_refusal("polygon5 3 7 { };") ==
              of_line_2(12, "flags are 7, known are 3 and 131 (back faces culled)"));
        CHECK(element_refusal("polygon5 3 3 { 0 0 0 spec; };") ==
              of_line_2(22, "found 'spec', expected ';' or 'diff' behind a corner"));
    }

    TEST_CASE("a file that is not there, and which files are archives") {
        CHECK_THROWS_WITH_AS(phigs::read_archive("/nowhere/a.phigs"),
                             "/nowhere/a.phigs: cannot be opened: No such file or directory",
                             host::RequestError);
    }
}
