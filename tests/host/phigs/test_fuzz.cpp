// Damaged archives: whatever the text, it is read or refused with a place.
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <random>

#include "tests/host/phigs/support.hpp"
#include "tests/random_seed.hpp"

using namespace pxpl5;
using namespace pxpl5::test;

namespace {

std::string archive(const std::string& name) {
    std::ifstream file(std::string(PXPL5_SOURCE_DIR) + "/host/phigs/archives/" + name + ".phigs");
    return {std::istreambuf_iterator<char>(file), {}};
}

/// Small, and with everything in it.
const std::string all_constructs =
    "/* c */ structure a { color polygon { diff 1 2 3 255 4 5 6 255 spec 1 2 3 4 1 2 3 4 };\n"
    "polygon 4 { 0 0 0; 1 0 0; 1 1 0; 0 1 0; }; sphere 0 0 0 1; };\n"
    "structure b posted { matrix Pre scale 2 2 2; matrix Pre translate 1 2 3;\n"
    "matrix Pre rotate z 45; execute a; polygon5 3 131 diff 9 9 9 255 { 0 0 0 0 0 1;\n"
    "1 0 0 0 0 1 diff 1 1 1 255; 0 1 0 0 0 1; }; line 3 { 0 0 0; 1 1 1; 2 0 0; }; };\n";

std::string damaged(std::string text, std::mt19937_64& random) {
    const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random() % n); };
    for (std::size_t hits = 1 + below(4); hits > 0 && !text.empty(); --hits) {
        const std::size_t at = below(text.size()), length = 1 + below(8);
        switch (below(5)) {
            case 0:
                text[at] = static_cast<char>(random());
                break;
            case 1:
                text.erase(at, length);
                break;
            case 2:
                text.insert(at, text.substr(below(text.size()), length));
                break;
            case 3:
                text.insert(at, std::string(1, "{};/*-.e9 \n"[below(11)]));
                break;
            default:
                text.resize(at);
        }
    }
    return text;
}

}  // namespace

TEST_SUITE("phigs/fuzz") {
    TEST_CASE("damaged text is read, or refused with its file, line and column") {
        const std::uint64_t seed = seed_or<std::uint64_t>(1);
        std::mt19937_64 random(seed);
        CAPTURE(seed);
        REQUIRE(refusal(all_constructs) == "");
        int refused = 0;
        constexpr int rounds = 20'000;
        for (int round = 0; round < rounds; ++round) {
            const std::string text = damaged(all_constructs, random);
            const std::string said = refusal(text);
            CAPTURE(text);
            refused += said.empty() ? 0 : 1;
            CHECK((said.empty() || said.starts_with("a.phigs:")));
        }
        CHECK(refused > rounds / 2);
        CHECK(refused < rounds);
    }
    TEST_CASE("the archives that come along are read, and cut off anywhere, they are refused") {
        for (const char* name : {"molecule", "room", "tree"}) {
            const std::string text = archive(name);
            CAPTURE(name);
            REQUIRE(text.size() > 1000);
            CHECK(refusal(text) == "");
            const std::size_t last = text.rfind('}');
            for (std::size_t cut = 1; cut <= 20; ++cut) {
                CHECK(refusal(text.substr(0, last * cut / 20)) != "");
            }
        }
    }
}
