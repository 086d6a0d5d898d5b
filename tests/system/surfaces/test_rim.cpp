// Rims in pictures: light at the edges of a surface.
#include <doctest/doctest.h>

#include <cstddef>
#include <string>
#include <vector>

#include "tests/system/surfaces/bone.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using test::Bone;
using test::machine_of;

namespace {

int red(std::uint32_t pixel) {
    return static_cast<int>(pixel & 0xffU);
}

}  // namespace

TEST_CASE("a rim adds light at the edges of its surface alone, on any machine") {
    std::vector<std::uint32_t> first;
    for (const auto& [gps, renderers] : {std::pair{1, 1}, {3, 5}}) {
        CAPTURE(gps);
        Bone bone(machine_of(gps, renderers));
        const std::vector<std::uint32_t> alone = bone.draw();
        bone.run("surface skin iso=-300 opacity=0.25");
        const std::vector<std::uint32_t> plain = bone.draw();
        bone.run("surface skin rim=0.5");
        const std::vector<std::uint32_t> lit = bone.draw();
        int brighter = 0, same = 0;
        for (std::size_t i = 0; i < lit.size(); ++i) {
            if (plain[i] == alone[i]) {  // The pixel does not show the skin.
                CHECK(lit[i] == plain[i]);
            }
            CHECK(red(lit[i]) >= red(plain[i]));
            brighter += red(lit[i]) >= red(plain[i]) + 40 ? 1 : 0;
            same += plain[i] != alone[i] && red(lit[i]) <= red(plain[i]) + 4 ? 1 : 0;
        }
        CHECK(brighter > 100);
        CHECK(same > 100);  // Of the skin.
        first = first.empty() ? lit : first;
        CHECK(lit == first);
        bone.run("surface skin rim=0");
        CHECK(bone.draw() == plain);
    }
}

TEST_CASE("the rim is one of sixteen steps, and a wrong one is refused") {
    Bone bone(machine_of(1, 1));
    const auto rim_after = [&](const std::string& line) {
        bone.run(line);
        return bone.session.surfaces.find("bone")->rim;
    };
    CHECK(rim_after("surface bone rim=1") == 16);
    CHECK(rim_after("surface bone rim=0.52") == 8);
    CHECK(rim_after("surface bone iso=300") == 8);
    CHECK(bone.refusal("surface bone rim=1.1").find("rim: 1.1 is outside 0 .. 1") !=
          std::string::npos);
    CHECK(bone.refusal("surface bone rim=-0.1").find("rim: -0.1 is outside 0 .. 1") !=
          std::string::npos);
}

TEST_CASE("the reply says how a surface is drawn, in the steps that the machine has") {
    Bone bone(machine_of(1, 1));
    const auto has_style = [&](const std::string& line, const std::string& end) {
        const std::string text = bone.run(line).text;
        return text.ends_with(" ms" + end);
    };
    CHECK(has_style("surface bone iso=300", ""));
    CHECK(has_style("surface bone opacity=0.3", "; opacity 0.3125"));
    CHECK(has_style("surface bone rim=0.52", "; opacity 0.3125, rim 0.5"));
    CHECK(has_style("surface bone visible=no opacity=1", "; not visible, rim 0.5"));
    const std::string json = json_text(bone.run("surface bone opacity=0.1").fields);
    CHECK_MESSAGE(json.find(R"("visible":false,"opacity":0.125,"rim":0.5)") != std::string::npos,
                  json);
}
