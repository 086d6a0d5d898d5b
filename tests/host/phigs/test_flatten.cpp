#include <fmt/core.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "tests/host/phigs/support.hpp"

using namespace pxpl5;
using namespace pxpl5::test;

namespace {

const std::string triangle = "polygon 3 { 0 0 0; 1 0 0; 0 1 0; };";

glm::dvec3 corner(const phigs::Part& part, std::size_t k) {
    return part.vertices[part.indices[k]].p;
}

/// Returns the normal that the triangle's winding gives.
glm::dvec3 facing(const phigs::Part& part, std::size_t t) {
    const glm::dvec3 a = corner(part, 3 * t);
    return glm::normalize(glm::cross(corner(part, 3 * t + 1) - a, corner(part, 3 * t + 2) - a));
}

std::size_t primitives(const phigs::Content& content) {
    std::size_t count = 0;
    for (const phigs::Part& part : content.parts) {
        count += part.primitives();
    }
    return count;
}

}  // namespace

TEST_SUITE("phigs/flatten") {
    TEST_CASE("matrices act on what follows, the newest first, and end with their structure") {
        const phigs::Content c = content_of(
            "structure inner { matrix Pre translate 1 0 0; sphere 0 0 0 1; };"
            "structure outer posted { matrix Pre translate 10 0 0; matrix Pre scale 2 2 2;"
            " execute inner; sphere 0 0 0 1; };");
        REQUIRE(c.parts.size() == 1);
        REQUIRE(c.parts[0].spheres.size() == 2);
        CHECK(c.parts[0].spheres[0].center == glm::dvec3(12, 0, 0));
        CHECK(c.parts[0].spheres[0].radius == 2);
        CHECK(c.parts[0].spheres[1].center == glm::dvec3(10, 0, 0));
        CHECK(c.low == glm::dvec3(8, -2, -2));
        CHECK(c.high == glm::dvec3(14, 2, 2));
        CHECK(c.radius == 3);
    }

    TEST_CASE("colors are inherited by what is executed, and end with their structure") {
        const phigs::Content c = content_of(
            "structure in { sphere 0 0 0 1; color sphere { diff 9 9 9 255 }; sphere 1 0 0 1; };"
            "structure out posted { color sphere { diff 1 2 3 255 }; execute in; "
            "sphere 2 0 0 1; };");
        REQUIRE(c.materials.size() == 2);
        CHECK(c.materials[0].color.b == 3);
        CHECK(c.materials[1].color.b == 9);
        CHECK(c.parts[0].spheres.size() == 2);
        CHECK(c.parts[1].spheres.size() == 1);
    }

    TEST_CASE("what is not posted is drawn only where it is executed") {
        CHECK(primitives(content_of("structure a { sphere 0 0 0 1; };"
                                    "structure b posted { execute a; execute a; };")) == 2);
        CHECK(refusal("structure a { sphere 0 0 0 1; };") ==
              "a.phigs:1:1: none of 1 structures is posted, nothing is drawn");
        CHECK(refusal("") == "a.phigs:1:1: none of 0 structures is posted, nothing is drawn");
        CHECK(refusal("structure a posted { };") ==
              "a.phigs:1:1: the posted structures draw nothing");
    }

    TEST_CASE("faces without normals get their own, and a mirror keeps the front") {
        const phigs::Content plain = content_of(posted(triangle));
        CHECK(facing(plain.parts[0], 0) == glm::dvec3(0, 0, 1));
        CHECK(plain.parts[0].vertices[0].normal == glm::dvec3(0, 0, 1));
        const phigs::Content mirrored = content_of(posted("matrix Pre scale -1 1 1;" + triangle));
        CHECK(facing(mirrored.parts[0], 0) == glm::dvec3(0, 0, 1));
        CHECK(mirrored.parts[0].vertices[0].normal == glm::dvec3(0, 0, 1));
    }

    TEST_CASE("normals stay perpendicular under unequal scales") {
        // A plane x + y = 1 of normal (1, 1, 0); x twice as long makes it x / 2 + y = 1.
        const phigs::Content c = content_of(posted(
            "matrix Pre scale 2 1 1; polygon 3 { 1 0 0 1 1 0; 0 1 0 1 1 0; 0 1 1 1 1 0; };"));
        const glm::dvec3 expected = glm::normalize(glm::dvec3(0.5, 1, 0));
        CHECK(glm::distance(c.parts[0].vertices[1].normal, expected) < 1e-12);
    }

    TEST_CASE("a polygon of two colors is drawn once for each side") {
        const phigs::Content c =
            content_of(posted("color polygon { diff 1 1 1 255 2 2 2 255 };" + triangle));
        REQUIRE(c.materials.size() == 2);
        CHECK(c.materials[0].cull_back);
        CHECK(c.materials[1].cull_back);
        CHECK(facing(c.parts[0], 0) == glm::dvec3(0, 0, 1));
        CHECK(facing(c.parts[1], 0) == glm::dvec3(0, 0, -1));
        CHECK(c.materials[1].color.r == 2);
    }

    TEST_CASE("polygon5 culls where it says so, and has the mean of its corners' colors") {
        const phigs::Content c = content_of(
            posted("polygon5 3 131 diff 9 9 9 255 { 0 0 0 diff 10 0 0 255; 1 0 0 diff 21 0 0 255; "
                   "0 1 0; }; polygon5 3 3 diff 9 9 9 255 { 0 0 0; 1 0 0; 0 1 0; };"));
        REQUIRE(c.materials.size() == 2);
        CHECK(c.materials[0].cull_back);
        CHECK(c.materials[0].color.r == 16);  // 15.5, rounded.
        CHECK(!c.materials[1].cull_back);
        CHECK(c.materials[1].color.r == 9);
        REQUIRE(c.notes.size() == 1);
        CHECK(c.notes[0] == "polygons drawn in the mean of their corners' colors: 1");
    }

    TEST_CASE("polygons without area are left out and told of") {
        const phigs::Content c =
            content_of(posted("polygon 3 { 0 0 0; 1 1 1; 2 2 2; };" + triangle));
        CHECK(primitives(c) == 1);
        REQUIRE(c.notes.size() == 1);
        CHECK(c.notes[0] == "polygons left out, as they have no area: 1");
    }

    TEST_CASE("the gloss of most primitives is taken") {
        const phigs::Content c =
            content_of(posted("color sphere { spec 10 20 30 5 }; sphere 0 0 0 1; sphere 1 0 0 1;"
                              "color sphere { spec 1 1 1 1 }; sphere 2 0 0 1;"));
        CHECK(c.has_specular);
        CHECK(c.specular.rgb == std::array{10.0, 20.0, 30.0});
        CHECK(c.specular.power == 5);
        CHECK(c.notes ==
              std::vector<std::string>{"2 kinds of gloss are drawn as the commonest one"});
        CHECK(!content_of(posted("sphere 0 0 0 1;")).has_specular);
    }

    TEST_CASE("translucent colors are told of") {
        CHECK(
            content_of(posted("color line { diff 1 1 1 128 }; line 2 { 0 0 0; 1 0 0; };")).notes ==
            std::vector<std::string>{"translucent colors, drawn opaque: 1"});
    }

    TEST_CASE("255 colors stay as they are, more lose lower bits") {
        const auto grays = [](int count) {
            std::string text;
            for (int i = 0; i < count; ++i) {
                text += fmt::format("color sphere {{ diff {} {} 0 255 }}; sphere {} 0 0 1;",
                                    i % 200, i / 200, i);
            }
            return content_of(posted(text));
        };
        const phigs::Content few = grays(255);
        CHECK(few.materials.size() == 255);
        CHECK(few.notes.empty());
        const phigs::Content many = grays(256);
        // 200 reds of which 7 bits leave 100, green 0 and 1 become one.
        CHECK(many.materials.size() == 100);
        CHECK(primitives(many) == 256);
        CHECK(many.notes == std::vector<std::string>{"256 colors are drawn as 100: 7 bits of each "
                                                     "channel are kept"});
        for (std::size_t i = 1; i < many.parts.size(); ++i) {
            CHECK(many.parts[i - 1].material <= many.parts[i].material);
        }
        CHECK(many.parts.size() == 100);
    }

    TEST_CASE("parts are of limited size, whatever the colors") {
        std::string text;
        for (std::size_t i = 0; i < 3 * phigs::primitives_per_part + 1; ++i) {
            text += fmt::format("sphere {} 0 0 1;", i);
        }
        const phigs::Content c = content_of(posted(text));
        REQUIRE(c.parts.size() == 4);
        CHECK(c.parts[3].spheres.size() == 1);
        CHECK(c.parts[3].spheres[0].center.x == 3 * phigs::primitives_per_part);
    }

    TEST_CASE("what cannot be executed is said with its place") {
        CHECK(refusal(posted("execute t;")) == "a.phigs:1:30: there is no structure t to execute");
        CHECK(refusal(posted("execute s;")) == "a.phigs:1:30: structure s executes itself");
        CHECK(refusal("structure a posted { execute b; }; structure b { execute a; };") ==
              "a.phigs:1:58: structure a executes itself");
        CHECK(refusal(posted("matrix Pre scale 1 2 1; sphere 0 0 0 1;")) ==
              "a.phigs:1:46: the matrices in force scale x, y, z by 1, 2, 1: this sphere would be "
              "an ellipsoid");
        std::string far;
        for (int i = 0; i < 3; ++i) {
            far += "matrix Pre scale 1e6 1e6 1e6;";
        }
        CHECK(refusal(posted(far)) ==
              "a.phigs:1:1: the matrices of structure s reach beyond 1000000000000000");
    }

    TEST_CASE("nesting has its limit, and so has what multiplies") {
        const auto chain = [](int count, const std::string& twice) {
            std::string text = "structure s0 { sphere 0 0 0 1; };\n";
            for (int i = 1; i < count; ++i) {
                text += fmt::format("structure s{} {} {{ execute s{};{} }};\n", i,
                                    i + 1 == count ? "posted" : "", i - 1,
                                    twice.empty() ? "" : fmt::format(" execute s{};", i - 1));
            }
            return text;
        };
        CHECK(primitives(content_of(chain(64, ""))) == 1);
        CHECK(refusal(chain(65, "")) ==
              "a.phigs:2:25: structure s0 would be executed 65 deep, 64 "
              "are the most");
        CHECK(refusal(chain(30, "twice"))
                  .find("more than 2000000 triangles, spheres and lines are "
                        "drawn, here by structure s0") != std::string::npos);
    }
}
