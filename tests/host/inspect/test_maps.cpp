#include <doctest/doctest.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <random>
#include <set>

#include "host/base/error.hpp"
#include "host/chart/chart.hpp"
#include "host/inspect/map/map_colors.hpp"
#include "host/inspect/map/map_picture.hpp"
#include "host/inspect/map/map_values.hpp"
#include "isa/assemble.hpp"
#include "isa/reference/reference.hpp"
#include "tests/host/inspect/recorded_sphere.hpp"
#include "tests/isa/random_program.hpp"
#include "tests/random_seed.hpp"

using namespace pxpl5;
namespace inspect = host::inspect;
using inspect::MapKind;
using isa::reference::Window;

namespace {

constexpr int gps = 3;

/// A ball over two regions, drawn by three GPs and two Renderers.
struct Ball {
    test::TracedSphere traced{{200, 128}, gps, 2};
    inspect::RecordedRun run = traced.run();
    inspect::RecordedFrame frame = run.frame(0);
};

const Ball& ball() {
    static const Ball made;
    return made;
}

std::size_t at(int x, int y) {
    return static_cast<std::size_t>(y * region_px + x);
}

/// The census of one pixel, counted on the reference.
struct Expected {
    std::uint32_t active = 0, covered = 0, written = 0;
    std::uint32_t visible = inspect::no_primitive;
    bool used = false, wrote = false;  ///< In the primitive under way.
};

/// Runs a region on the reference, in a window, and counts by the definitions.
std::vector<Expected> count_on_reference(const inspect::RecordedRegion& region,
                                         const std::vector<inspect::Primitive>& primitives,
                                         Window window) {
    isa::reference::Reference executor(window);
    inspect::RegionWalk walk(region.plan, executor);
    std::vector<Expected> pixels(static_cast<std::size_t>(window.width) *
                                 static_cast<std::size_t>(window.height));
    bool used = false;
    while (!walk.done()) {
        const inspect::Primitive* primitive = inspect::primitive_at(primitives, walk.at());
        if (primitive != nullptr && primitive->address() == walk.at()) {
            used = false;
            for (Expected& pixel : pixels) {
                pixel.wrote = false;
            }
        }
        const isa::OpInfo& row = isa::info(walk.next().op);
        const bool touches = row.pattern.a.mask != 0 && primitive != nullptr;
        for (std::size_t i = 0; i < pixels.size(); ++i) {
            const int x = window.x0 + static_cast<int>(i) % window.width;
            const int y = window.y0 + static_cast<int>(i) / window.width;
            const bool enabled = executor.enabled(x, y);
            pixels[i].active += enabled ? 1 : 0;
            pixels[i].covered += enabled && touches && !used ? 1 : 0;
            if (enabled && touches && (row.effects & isa::mem) != 0) {
                pixels[i].written += pixels[i].wrote ? 0 : 1;
                pixels[i].wrote = true;
                pixels[i].visible = static_cast<std::uint32_t>(primitive->number);
            }
        }
        used = used || touches;
        walk.step();
    }
    return pixels;
}

/// A region of a prologue and the given assembly as its one segment.
struct OwnRegion {
    explicit OwnRegion(const std::string& prologue_text, const std::string& text)
        : prologue(isa::assemble(prologue_text).words), words(isa::assemble(text).words) {
        using Kind = PartKind;
        region.plan.parts = {{Kind::prologue, {}}, {Kind::segment, {}}, {Kind::end_of_region, {}}};
        region.plan.parts[0].segment.words = prologue;
        region.plan.parts[1].segment.words = words;
        region.plan.parts[2].segment.words = end;
        for (std::size_t word = 0; word < words.size();
             word += isa::instruction_words(words[word])) {
            if (words[word] == isa::encode({isa::Op::set_enabs, {}})) {
                primitives.push_back({1, primitives.size(), word, words.size() - word, {}});
            }
        }
    }
    std::vector<std::uint32_t> prologue, words;
    std::vector<std::uint32_t> end = isa::assemble("PIXELSTOFB m64:24").words;
    inspect::RecordedRegion region;
    std::vector<inspect::Primitive> primitives;
};

}  // namespace

TEST_CASE("bit maps are counted bit by bit") {
    const std::uint64_t seed = test::seed_or<std::uint64_t>(21);
    INFO("PXPL5_SEED=", seed);
    std::mt19937_64 random(seed);
    inspect::BitMapCounter counter;
    std::vector<std::uint32_t> expected(region_pixels);
    for (int i = 0; i < 300; ++i) {
        inspect::BitMapCounter::Map map;
        std::ranges::generate(map, std::ref(random));
        const std::size_t first = random() % map.size(), count = map.size() - first;
        counter.add(map, first, count);
        for (std::size_t bit = first * 64; bit < (first + count) * 64; ++bit) {
            expected[bit] += (map[bit / 64] >> bit % 64 & 1) != 0 ? 1 : 0;
        }
    }
    for (std::size_t bit = 0; bit < region_pixels; ++bit) {
        REQUIRE(counter.count(bit) == expected[bit]);
    }
}

TEST_CASE("a region's counts are those of the reference, pixel by pixel") {
    const inspect::RecordedRegion& region = ball().frame.regions.at(0);
    const auto primitives = inspect::primitives_of(ball().frame, region);
    const inspect::RegionCensus census = inspect::take_census(region, primitives);
    int outline = 0;
    while (census.visible[at(outline, 62)] == inspect::no_primitive) {
        ++outline;
    }
    // In the middle of the ball, and on its outline.
    for (const Window window : {Window{97, 61, 5, 4}, Window{outline - 3, 61, 8, 2}}) {
        const std::vector<Expected> pixels = count_on_reference(region, primitives, window);
        std::size_t visible = 0;
        for (std::size_t i = 0; i < pixels.size(); ++i) {
            const int x = window.x0 + static_cast<int>(i) % window.width;
            const int y = window.y0 + static_cast<int>(i) / window.width;
            CAPTURE(x);
            CAPTURE(y);
            REQUIRE(census.active[at(x, y)] == pixels[i].active);
            REQUIRE(census.covered[at(x, y)] == pixels[i].covered);
            REQUIRE(census.written[at(x, y)] == pixels[i].written);
            REQUIRE(census.visible[at(x, y)] == pixels[i].visible);
            visible += pixels[i].visible != inspect::no_primitive ? 1 : 0;
        }
        CHECK(visible > 3);
    }
}

TEST_CASE("of one triangle the pixels inside are covered and written once, the others never") {
    // Inside: x >= 10, y >= 20, x + y <= 60. z 5, and depth 100 before.
    const OwnRegion own("SETENABS\nCONSTintoMEM m8:24 100\nCONSTintoMEM m64:24 7\n",
                        "SETENABS\nTREEgeZERO :16 1 0 -10\nTREEgeZERO :16 0 1 -20\n"
                        "TREEgeZERO :16 -1 -1 60\nTREEltMEM m8:24 >>0 0 0 5\n"
                        "TREEintoMEM m8:24 >>0 0 0 5\nIMMintoMEM m0:8 #1\n");
    const inspect::RegionCensus census = inspect::take_census(own.region, own.primitives);
    CHECK(census.counts.instructions == 11);
    for (int y = 0; y < region_px; ++y) {
        for (int x = 0; x < region_px; ++x) {
            const bool first = x >= 10, second = first && y >= 20, inside = second && x + y <= 60;
            REQUIRE(census.covered[at(x, y)] == (inside ? 1 : 0));
            REQUIRE(census.written[at(x, y)] == (inside ? 1 : 0));
            REQUIRE(census.visible[at(x, y)] == (inside ? 0 : inspect::no_primitive));
            REQUIRE(census.z[at(x, y)] == (inside ? 5 : 100));
            REQUIRE(census.surface[at(x, y)] == (inside ? 1 : 0));
            REQUIRE(census.rgb[at(x, y)] == 7);
            // Two of the prologue, SETENABS and the first edge begin with everything enabled (but
            // the very first SETENABS with nothing); five more, one after the other, with less.
            const std::uint32_t active = 4 + (first ? 1 : 0) + (second ? 1 : 0) + (inside ? 4 : 0);
            REQUIRE(census.active[at(x, y)] == active);
        }
    }
}

TEST_CASE("a hidden triangle covers and does not write") {
    const std::string triangle =
        "SETENABS\nTREEgeZERO :16 1 0 -10\nTREEltMEM m8:24 >>0 0 0 {}\n"
        "TREEintoMEM m8:24 >>0 0 0 {}\nIMMintoMEM m0:8 #1\n";
    const OwnRegion own(
        "SETENABS\nCONSTintoMEM m8:24 100\n",
        fmt::format(fmt::runtime(triangle), 5, 5) + fmt::format(fmt::runtime(triangle), 6, 6));
    const inspect::RegionCensus census = inspect::take_census(own.region, own.primitives);
    CHECK(census.covered[at(10, 3)] == 2);
    CHECK(census.written[at(10, 3)] == 1);
    CHECK(census.visible[at(10, 3)] == 0);
    CHECK(census.covered[at(9, 3)] == 0);
}

TEST_CASE("maps of a frame: idle and busy add up, cost is what the Renderer reported") {
    std::map<std::uint32_t, inspect::RegionCensus> census;
    for (const auto& [number, region] : ball().frame.regions) {
        census.emplace(number,
                       inspect::take_census(region, inspect::primitives_of(ball().frame, region)));
    }
    const auto map = [&](MapKind kind) { return map_values(ball().frame, kind, census); };
    const inspect::MapValues idle = map(MapKind::idle), busy = map(MapKind::busy);
    const inspect::MapValues cost = map(MapKind::cost), renderer = map(MapKind::renderer);
    REQUIRE(idle.width == 200);
    REQUIRE(idle.height == 128);
    for (int y = 0; y < 128; ++y) {
        for (int x = 0; x < 200; ++x) {
            const auto i = static_cast<std::size_t>(y * 200 + x);
            const std::uint32_t number = x < 128 ? 0 : 1;
            const inspect::RecordedRegion& region = ball().frame.regions.at(number);
            const auto* pixels =
                ball().frame.pixels.find(region.renderer)->second.as<bus::schema::RegionPixels>();
            const auto* tile = pixels->tiles()->Get(0);
            REQUIRE(tile->region() == number);
            REQUIRE(idle.values[i] + busy.values[i] ==
                    static_cast<std::int64_t>(tile->instructions()));
            REQUIRE(cost.values[i] == static_cast<std::int64_t>(tile->cycles()));
            REQUIRE(renderer.values[i] == region.renderer);
            const auto in_tile = static_cast<std::uint32_t>(y * region_px + x % region_px);
            REQUIRE(idle.picture[i] == pixels->pixels()->Get(in_tile));
        }
    }
}

TEST_CASE("the visible GP, slab and case are those of a primitive that has the visible depth") {
    const inspect::MapValues gp = map_values(ball().frame, MapKind::gp);
    const inspect::MapValues slab = map_values(ball().frame, MapKind::slab);
    const inspect::MapValues cases = map_values(ball().frame, MapKind::cell_case);
    const inspect::MapValues depth = map_values(ball().frame, MapKind::depth);
    const inspect::MapValues normal = map_values(ball().frame, MapKind::normal);
    std::size_t drawn = 0;
    for (std::size_t i = 0; i < gp.values.size(); ++i) {
        const bool is_drawn = gp.values[i] != inspect::no_value;
        REQUIRE((depth.values[i] != inspect::no_value) == is_drawn);
        REQUIRE((normal.values[i] != inspect::no_value) == is_drawn);
        REQUIRE((slab.values[i] != inspect::no_value) == is_drawn);
        if (is_drawn) {
            ++drawn;
            REQUIRE(gp.values[i] == slab.values[i] % gps);  // Slabs are dealt round-robin.
            REQUIRE(cases.values[i] >= 1);                  // Case 0 has no triangle.
        }
    }
    CHECK(drawn > 1000);
}

TEST_CASE("turns, and swapping inside and outside, keep a case's class, and there are fifteen") {
    std::array<int, 15> sets{};
    for (int set = 0; set < 256; ++set) {
        const int number = inspect::case_class(static_cast<std::uint8_t>(set));
        REQUIRE(number >= 0);
        REQUIRE(number < 15);
        ++sets[static_cast<std::size_t>(number)];
        CHECK(inspect::case_class(static_cast<std::uint8_t>(~set)) == number);
    }
    // Sets per class: 24 turns and the swap over the symmetries of each figure.
    CHECK(sets == std::array<int, 15>{2, 16, 24, 24, 8, 48, 48, 16, 6, 8, 6, 12, 24, 2, 12});
    CHECK(inspect::case_class(0x80) == 1);                          // One corner.
    CHECK(inspect::case_class(0x11) == 2);                          // The two of an edge along z.
    CHECK(inspect::case_class(0x55) == 8);                          // The face x = 0.
    CHECK(inspect::case_class(0x27) != inspect::case_class(0x1B));  // Mirrored chains.
}

TEST_CASE("a map without a value at a pixel leaves its number out") {
    inspect::MapValues map{MapKind::overdraw, 2, 2, {0, 12, inspect::no_value, 3}, {0, 0, 0, 0}};
    CHECK(inspect::to_csv(map) == "0,12\n,3\n");
    map.kind = MapKind::normal;
    map.values = {inspect::no_value, 0x3FF | 5 << 10 | 510 << 20, 0, 1 << 9};
    CHECK(inspect::to_csv(map) == ",-1:5:510\n0:0:0,-512:0:0\n");
    CHECK_THROWS_AS(inspect::map_kind_of("heat"), host::RequestError);
}

TEST_CASE("the scale of counts grows lighter all the way") {
    double before = -1;
    for (int i = 0; i <= 100; ++i) {
        const inspect::Rgb8 c = inspect::sequential(i / 100.0);
        const double light = 0.2126 * c.r + 0.7152 * c.g + 0.0722 * c.b;
        CHECK(light > before);
        before = light;
    }
}

TEST_CASE("categories have colors of their own, as far as a paper's machine has GPs") {
    std::set<std::uint32_t> colors;
    for (std::uint32_t i = 0; i < 36; ++i) {
        colors.insert(inspect::categorical(i).opaque());
    }
    CHECK(colors.size() == 36);
}

/// Whether a mark of the picture says `text`.
bool shows(const inspect::MapPicture& picture, const std::string& text) {
    return std::ranges::any_of(picture.marks,
                               [&](const host::PictureMark& mark) { return mark.text == text; });
}

TEST_CASE("a map's legend has a title, a subject and ticks inside of the picture") {
    for (const int width : {100, 500, 1000}) {
        inspect::MapValues map{MapKind::overdraw, width, 2, {}, {}};
        for (int i = 0; i < 2 * width; ++i) {
            map.values.push_back(i % 90);
        }
        map.picture.assign(map.values.size(), 0x808080);
        const inspect::MapPicture picture = inspect::draw_map(map, {.subject = "frame 3"});
        CHECK(shows(picture, "frame 3"));
        CHECK(shows(picture, "1"));
        CHECK(shows(picture, "89"));
        for (const host::PictureMark& mark : picture.marks) {
            const double wide = host::text_width(mark.text, static_cast<double>(mark.height_px));
            for (const glm::vec2& p : mark.points) {
                const double left =
                    static_cast<double>(p.x) - wide * static_cast<double>(mark.align_x);
                CAPTURE(mark.text);
                CHECK(left >= 0);
                CHECK(left + wide <= picture.width);
                CHECK(p.y <= static_cast<float>(picture.height));
            }
        }
    }
}

TEST_CASE("a map of categories names each category, and one by regions labels each region") {
    inspect::MapValues map{MapKind::renderer, 200, 128, {}, {}};
    for (int i = 0; i < 200 * 128; ++i) {
        map.values.push_back(i % 200 < 128 ? 4 : 5);
    }
    map.picture.assign(map.values.size(), 0x808080);
    const inspect::MapPicture picture = inspect::draw_map(map, {.grid = true, .subject = ""});
    for (const char* text : {"renderer 4", "renderer 5", "4", "5"}) {
        CHECK(shows(picture, text));
    }
}

TEST_CASE("a drawn map holds its picture, larger numbers lighter, and a legend below") {
    inspect::MapValues map{MapKind::overdraw, 400, 20, {}, {}};
    for (int i = 0; i < 400 * 20; ++i) {
        map.values.push_back(i % 400);
    }
    map.picture.assign(map.values.size(), 0x808080);
    const inspect::MapPicture picture = inspect::draw_map(map, {.subject = "frame 3"});
    CHECK(picture.width == 400);
    CHECK(picture.height > 40);
    REQUIRE(picture.rgba.size() == static_cast<std::size_t>(picture.width * picture.height));
    const auto green = [&](std::size_t i) { return picture.rgba[i] >> 8 & 0xFF; };
    CHECK(green(0) < green(200));
    CHECK(green(200) < green(399));
    CHECK((picture.rgba[0] >> 24) == 0xFF);
    // Equal numbers over equal gray have the same color, row by row.
    CHECK(picture.rgba[5] == picture.rgba[400 * 7 + 5]);
    // A picture too narrow for the legend stands in the middle of a wider one.
    map = {MapKind::overdraw, 2, 1, {1, 1}, {0, 0}};
    const inspect::MapPicture narrow = inspect::draw_map(map, {});
    CHECK(narrow.width > 300);
    const auto left = static_cast<std::size_t>((narrow.width - 2) / 2);
    CHECK(narrow.rgba[left] != narrow.rgba[left - 1]);
    CHECK(narrow.rgba[left] == narrow.rgba[left + 1]);
    CHECK(inspect::short_number(9999) == "9999");
    CHECK(inspect::short_number(12345) == "12.35k");
    CHECK(inspect::short_number(1234567) == "1.235M");
}
