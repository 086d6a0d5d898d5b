// Compares transparent surfaces and depths with coverage x pattern x depth in plain C++.
#include <algorithm>
#include <array>

#include "isa/reference/reference.hpp"
#include "renderer_firmware/igc/region.hpp"
#include "renderer_firmware/igc/region_program.hpp"
#include "tests/random_seed.hpp"
#include "tests/renderer_firmware/targets.hpp"
#include "tests/renderer_firmware/triangles.hpp"

using namespace pxpl5;
using renderer::RegionPlan;

namespace {

constexpr int side = 128;
constexpr std::uint32_t far_z = (1U << 24) - 1;
using WordList = std::vector<std::uint32_t>;

/// The ordered 4 x 4 pattern of Bayer (1973), by row, and the pattern of lines.
constexpr std::uint32_t bayer[4][4] = {
    {0, 8, 2, 10}, {12, 4, 14, 6}, {3, 11, 1, 9}, {15, 7, 13, 5}};
constexpr std::uint32_t lines[4][4] = {
    {0, 5, 2, 7}, {8, 13, 10, 15}, {4, 1, 6, 3}, {12, 9, 14, 11}};

std::uint32_t rank(std::uint32_t pattern, int x, int y) {
    const int first = static_cast<int>(pattern / 3 % 2), second = static_cast<int>(pattern / 6 % 2);
    switch (pattern % 3) {
        case 0:
            return bayer[(y + second) % 4][(x + first) % 4];
        case 1:
            return lines[(y + second) % 4][(x + first) % 4];
        default:
            return lines[(x + 1 + second) % 4][(y + first) % 4];
    }
}

/// A triangle over the whole region.
test::TrianglePlanes sheet(std::uint32_t surface, std::uint32_t depth) {
    test::TrianglePlanes t;
    put_edges({-3000, -3000}, {9000, -3000}, {-3000, 9000}, t);
    t.z[2] = static_cast<std::int32_t>(depth << 8);
    t.surface = surface + 1;
    return t;
}

struct Slab {
    std::uint32_t surface = 0, slab = 0;
    std::vector<test::TrianglePlanes> triangles;
};

/// Surfaces with triangles of all sizes, their opacities, and a background.
struct Scene {
    renderer::Shading shading;
    std::vector<Slab> slabs;  ///< In order of execution.
    std::vector<WordList> words;

    explicit Scene(std::uint64_t seed) {
        test::RandomPrograms random(seed);
        shading.ambient = 1;  // Without lights a pixel has its surface's color.
        shading.background = {9, 18, 27};
        for (std::uint32_t s = 0; s < 8; ++s) {
            const auto part = [&] { return static_cast<std::uint8_t>(random.below(256)); };
            shading.surfaces.push_back({part(), part(), part()});
            shading.screens.push_back({s == 2 ? 16 : 1 + random.below(16), random.below(12)});
            for (std::uint32_t slab = 0; slab < 3; ++slab) {
                add(random, s, slab);
            }
        }
    }

    std::vector<renderer::Segment> segments() const {
        std::vector<renderer::Segment> all;
        for (std::size_t i = slabs.size(); i-- > 0;) {
            all.push_back({slabs[i].surface, slabs[i].slab, 0, words[i], 0});
        }
        return all;
    }

  private:
    void add(test::RandomPrograms& random, std::uint32_t surface, std::uint32_t slab) {
        constexpr std::int32_t reaches[] = {24, 160, 1000, 4000};
        Slab& made = slabs.emplace_back(Slab{surface, slab, {}});
        WordList& out = words.emplace_back();
        for (int n = 0; n < 12; ++n) {
            const test::Corner center{static_cast<std::int32_t>(random.below(2048)),
                                      static_cast<std::int32_t>(random.below(2048))};
            test::TrianglePlanes t =
                test::random_triangle(random, center, reaches[random.below(4)]);
            t.surface = surface + 1;
            append(t, out);
            made.triangles.push_back(t);
        }
    }
};

/// The surface field of a pixel, and its depth above the field.
std::uint32_t expected_at(const Scene& scene, int x, int y) {
    const auto form = [x, y](const std::int32_t* k) {
        return std::int64_t{k[0]} * x + std::int64_t{k[1]} * y + k[2];
    };
    std::uint32_t z = far_z, surface = 0;
    for (const Slab& slab : scene.slabs) {
        const renderer::Screen& screen = scene.shading.screens[slab.surface];
        if (screen.opacity < 16 && rank(screen.pattern, x, y) >= screen.opacity) {
            continue;
        }
        for (const test::TrianglePlanes& t : slab.triangles) {
            const bool inside =
                std::ranges::all_of(t.edges, [&](const auto& e) { return form(e) >= 0; });
            const auto depth = static_cast<std::uint32_t>(form(t.z) >> 8) & far_z;
            if (inside && depth < z) {
                z = depth;
                surface = t.surface;
            }
        }
    }
    return surface | z << 8;
}

struct Drawn {
    renderer::RegionResult result;
    WordList pixels, depths;
    std::vector<PartKind> parts;
};

Drawn draw(isa::Executor& executor, const renderer::RegionPrograms& programs,
           std::vector<renderer::Segment> segments) {
    renderer::RegionFrame frame{programs.prologue, programs.end_of_region};
    for (const renderer::DoorPrograms& door : programs.doors) {
        frame.doors.push_back({door.surface, door.shut, door.open});
    }
    frame.depths = programs.depths;
    Drawn drawn;
    executor.set_readout([&](renderer::Words words) {
        WordList& to = drawn.parts.back() == PartKind::depths ? drawn.depths : drawn.pixels;
        to.assign(words.begin(), words.end());
    });
    drawn.result = draw_region(executor, frame, std::move(segments),
                               [&](PartKind kind) { drawn.parts.push_back(kind); });
    executor.set_readout({});
    return drawn;
}

std::uint32_t color_of(const renderer::Shading& shading, std::uint32_t field) {
    const renderer::Rgb c = field == 0 ? shading.background : shading.surfaces[field - 1];
    return c.r | c.g << 8U | c.b << 16U;
}

/// Returns where a surface appears in 4 x 4 pixels, as drawn.
std::vector<bool> drawn_screen(renderer::Screen screen) {
    WordList words;
    append(sheet(0, 5000), words);
    renderer::Shading shading;
    shading.surfaces = {{200, 100, 50}};
    shading.screens = {screen};
    renderer::fast::Fast fast;
    const Drawn drawn = draw(fast, region_programs(shading, true), {{0, 0, 0, words, 0}});
    std::vector<bool> shown(16);
    for (int i = 0; i < side * side; ++i) {
        const int x = i % side, y = i / side;
        const auto place = static_cast<std::size_t>(y % 4 * 4 + x % 4);
        const bool here = drawn.depths[static_cast<std::size_t>(i)] == (1 | 5000 << 8);
        if (x < 4 && y < 4) {
            shown[place] = here;
        }
        REQUIRE(shown[place] == here);
    }
    return shown;
}

}  // namespace

TEST_CASE("transparent surfaces show in their pixels of the pattern, as the depth test decides") {
    const std::uint64_t seed = test::seed_or<std::uint64_t>(41);
    MESSAGE("PXPL5_SEED=", seed);
    for (std::uint64_t n = 0; n < 6; ++n) {
        const Scene scene(seed + n);
        const renderer::RegionPrograms programs = region_programs(scene.shading, true);
        test::on_every_target([&](renderer::fast::Fast& fast) {
            fast.reset();
            const Drawn drawn = draw(fast, programs, scene.segments());
            REQUIRE(drawn.result.faults.empty());
            REQUIRE(drawn.depths.size() == region_pixels);
            int wrong = 0, covered = 0;
            for (int i = 0; i < side * side; ++i) {
                const std::uint32_t expected = expected_at(scene, i % side, i / side);
                const auto at = static_cast<std::size_t>(i);
                wrong += drawn.depths[at] == expected ? 0 : 1;
                wrong += drawn.pixels[at] == color_of(scene.shading, expected & 0xFF) ? 0 : 1;
                covered += (expected & 0xFF) != 0 ? 1 : 0;
            }
            CHECK(wrong == 0);
            CHECK(covered > side * side / 4);
        });
    }
}

TEST_CASE("the reference executor draws doors and depths as the fast one does") {
    const Scene scene(test::seed_or<std::uint64_t>(43));
    const renderer::RegionPrograms programs = region_programs(scene.shading, true);
    isa::reference::Reference reference({52, 60, 16, 8});
    renderer::fast::Fast fast;
    const Drawn slow = draw(reference, programs, scene.segments());
    const Drawn quick = draw(fast, programs, scene.segments());
    CHECK(slow.result.counts.instructions == quick.result.counts.instructions);
    CHECK(slow.result.counts.cycles == quick.result.counts.cycles);
    for (int y = 60; y < 68; ++y) {
        for (int x = 52; x < 68; ++x) {
            const auto at = static_cast<std::size_t>(y * side + x);
            CHECK(slow.depths[at] == expected_at(scene, x, y));
            CHECK(slow.depths[at] == quick.depths[at]);
            CHECK(slow.pixels[at] == quick.pixels[at]);
        }
    }
}

TEST_CASE("each opacity shows in that many of every 4 x 4 pixels, and in those of the one before") {
    for (std::uint32_t pattern = 0; pattern < 12; ++pattern) {
        std::vector<bool> before(16, false);
        for (std::uint32_t opacity = 1; opacity <= 16; ++opacity) {
            const std::vector<bool> now = drawn_screen({opacity, pattern});
            CHECK(std::ranges::count(now, true) == opacity);
            for (std::size_t p = 0; p < 16; ++p) {
                CHECK((now[p] || !before[p]));
            }
            before = now;
        }
    }
}

TEST_CASE("two surfaces let through about the product of what each lets through") {
    const auto through = [](std::initializer_list<renderer::Screen> screens) {
        std::vector<bool> open(16, true);
        for (const renderer::Screen& screen : screens) {
            const std::vector<bool> shown = drawn_screen(screen);
            for (std::size_t p = 0; p < 16; ++p) {
                open[p] = open[p] && !shown[p];
            }
        }
        return std::ranges::count(open, true);
    };
    for (std::uint32_t p = 0; p < 3; ++p) {
        for (std::uint32_t q = 0; q < 3; ++q) {
            if (p != q) {
                CHECK(through({{8, p}, {8, q}}) == 4);
                CHECK(std::abs(through({{12, p}, {12, q}}) - 1) <= 1);
                CHECK(std::abs(through({{4, p}, {4, q}}) - 9) <= 1);
                CHECK(std::abs(through({{4, p}, {8, q}}) - 6) <= 2);
            }
        }
    }
    CHECK(through({{8, 0}, {8, 1}, {8, 2}}) == 4);
}

TEST_CASE("what two surfaces of 8/16 leave to a third is even: no two of its pixels touch") {
    for (const auto& [p, q] : {std::pair(0U, 1U), std::pair(0U, 2U), std::pair(1U, 2U)}) {
        const std::vector<bool> one = drawn_screen({8, p}), other = drawn_screen({8, q});
        const auto open = [&](int x, int y) {
            const auto at = static_cast<std::size_t>((y & 3) * 4 + (x & 3));
            return !one[at] && !other[at];
        };
        for (int i = 0; i < 16; ++i) {
            for (int step = 0; step < 9 && open(i % 4, i / 4); ++step) {
                if (step != 4) {
                    CHECK_FALSE(open(i % 4 + step % 3 - 1, i / 4 + step / 3 - 1));
                }
            }
        }
    }
}

TEST_CASE("no pattern has clumps or stripes: the pixels of 4/16 do not touch by their sides") {
    for (std::uint32_t pattern = 0; pattern < 12; ++pattern) {
        const std::vector<bool> four = drawn_screen({4, pattern}), two = drawn_screen({2, pattern});
        const auto at = [](const std::vector<bool>& shown, int x, int y) {
            return shown[static_cast<std::size_t>((y & 3) * 4 + (x & 3))];
        };
        for (int y = 0; y < 4; ++y) {
            for (int x = 0; x < 4; ++x) {
                CHECK_FALSE((at(four, x, y) && (at(four, x + 1, y) || at(four, x, y + 1))));
                for (int step = -1; step <= 1; ++step) {
                    CHECK_FALSE((at(two, x, y) && at(two, x + step, y + 1)));
                }
            }
        }
    }
}

TEST_CASE("an opaque frame without depths runs just what it ran before") {
    Scene scene(test::seed_or<std::uint64_t>(44));
    scene.shading.screens.assign(8, {});
    const renderer::RegionPrograms programs = region_programs(scene.shading);
    CHECK(programs.doors.empty());
    CHECK(programs.depths.empty());
    renderer::fast::Fast fast;
    const Drawn drawn = draw(fast, programs, scene.segments());
    CHECK(drawn.parts.size() == 1 + scene.slabs.size() + 1);
}

TEST_CASE("only surfaces that are in a region have doors there, and a bad segment opens none") {
    Scene scene(test::seed_or<std::uint64_t>(45));
    scene.shading.screens.assign(8, {8, 0});
    const renderer::RegionPrograms programs = region_programs(scene.shading);
    const WordList bad = {0xEE000000};
    renderer::fast::Fast fast;
    using enum PartKind;
    const Drawn drawn = draw(fast, programs,
                             {{5, 1, 0, scene.words[0], 0},
                              {5, 0, 0, scene.words[1], 0},
                              {3, 0, 0, bad, 0},
                              {7, 0, 0, scene.words[2], 0}});
    CHECK(drawn.result.faults.size() == 1);
    CHECK(drawn.parts == std::vector{prologue, shut_door, segment, segment, open_door, shut_door,
                                     segment, open_door, end_of_region});
}

TEST_CASE("an opacity that cannot be is refused by name") {
    renderer::Shading shading;
    shading.surfaces.assign(1, {});
    for (const std::uint32_t opacity : {0U, 17U}) {
        shading.screens = {{opacity, 0}};
        CHECK_THROWS_WITH(
            region_programs(shading),
            ("shading: opacity " + std::to_string(opacity) + "; must be 1..16").c_str());
    }
    shading.screens.assign(2, {});
    CHECK_THROWS_WITH(region_programs(shading), "shading: 2 screens of 1 surfaces");
}
