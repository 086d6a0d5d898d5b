// Runs the programs of ASSEMBLER.md and ISA.md and compares the pictures with mathematics.
#include <doctest/doctest.h>

#include <fstream>
#include <functional>
#include <map>
#include <sstream>

#include "isa/assemble.hpp"
#include "isa/contract/region_layout.hpp"
#include "isa/reference/reference.hpp"
#include "isa/sequencer.hpp"

using namespace pxpl5;

namespace {

/// Returns the code blocks of a page that are marked as pxasm.
std::vector<std::string> programs_of(const std::string& page) {
    std::ifstream file(PXPL5_SOURCE_DIR "/isa/" + page, std::ios::binary);
    std::ostringstream all;
    all << file.rdbuf();
    const std::string text = all.str(), fence = "```";
    std::vector<std::string> blocks;
    for (std::size_t at = 0; (at = text.find(fence + "pxasm\n", at)) != std::string::npos;) {
        const std::size_t begin = text.find('\n', at) + 1;
        at = text.find(fence, begin);
        REQUIRE(at != std::string::npos);
        blocks.push_back(text.substr(begin, at - begin));
    }
    return blocks;
}

/// Returns "disc" for "; disc.pxasm: a red disc".
std::string name_of(const std::string& program) {
    const std::size_t end = program.find(".pxasm:");
    REQUIRE(program.starts_with("; "));
    REQUIRE(end != std::string::npos);
    return program.substr(2, end - 2);
}

isa::Parameters parameters_of(const isa::Program& program) {
    isa::Parameters values;
    for (const isa::Program::Patch& patch : program.patches) {
        values[patch.name] = patch.name == "color" ? 0x00ffff : -96;
    }
    return values;
}

int squared_distance(int x, int y, int center) {
    return (x - center) * (x - center) + (y - center) * (y - center);
}

/// Returns 0xBBGGRR of a pixel.
using Picture = std::function<int(int x, int y)>;

const std::map<std::string, Picture> pictures = {
    {"disc", [](int x, int y) { return squared_distance(x, y, 64) <= 50 * 50 ? 0xff : 0xff0000; }},
    {"gradient", [](int x, int y) { return 2 * x + 256 * 2 * y + 65536 * 64; }},
    {"triangle", [](int x, int y) { return x >= 20 && y <= 100 && x <= y ? 0x00ff00 : 0; }},
    {"bars", [](int x, int) { return x / 16 * 36 * 0x010101; }},
    {"curtain", [](int x, int) { return x >= 96 ? 0x00ffff : 0; }},
};

}  // namespace

TEST_CASE("every program of ASSEMBLER.md draws the picture that its first line names") {
    std::size_t drawn = 0;
    for (const std::string& text : programs_of("ASSEMBLER.md")) {
        const std::string name = name_of(text);
        INFO(name);
        REQUIRE(pictures.contains(name));
        const Picture& picture = pictures.at(name);
        const isa::Program program = isa::assemble(text);
        const std::vector<std::uint32_t> words = program.bind(parameters_of(program));
        REQUIRE(isa::check(words).ok());
        isa::reference::Reference pixels;
        isa::Controller controller;
        isa::run(words, pixels, controller);
        int wrong = 0;
        for (int y = 0; y < region_px; ++y) {
            for (int x = 0; x < region_px; ++x) {
                const isa::region::Field rgb = isa::region::rgb;
                wrong += pixels.field(x, y, rgb.address, rgb.width) !=
                         static_cast<std::uint64_t>(picture(x, y));
            }
        }
        CHECK(wrong == 0);
        ++drawn;
    }
    CHECK(drawn == pictures.size());
}

TEST_CASE("every example of ISA.md is a valid program") {
    const std::vector<std::string> examples = programs_of("ISA.md");
    CHECK(examples.size() == 6);
    for (const std::string& text : examples) {
        const isa::CheckResult result = isa::check(isa::assemble(text).words);
        CHECK_MESSAGE(result.ok(), text);
    }
}
