// Compares fused region programs with the same programs run instruction by instruction, and with
// the reference: memory, carries and enables of all pixels, on every target, from any state.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <memory>

#include "isa/reference/reference.hpp"
#include "isa/sequencer.hpp"
#include "renderer_firmware/igc/region_program.hpp"
#include "tests/isa/random_program.hpp"
#include "tests/random_seed.hpp"
#include "tests/renderer_firmware/targets.hpp"

using namespace pxpl5;
using renderer::Shading;
using renderer::fast::Fast;
using renderer::hal::PixelArray;

namespace {

using WordList = std::vector<std::uint32_t>;
using test::RandomPrograms;

constexpr isa::reference::Window window{.x0 = 61, .y0 = 30, .width = 6, .height = 4};
constexpr std::uint64_t first_seed = 20261121;

/// Pixels with random bits, of which a given share is covered.
enum class Coverage : std::uint8_t { none, one_pixel, some, all };
constexpr Coverage coverages[] = {Coverage::none, Coverage::one_pixel, Coverage::some,
                                  Coverage::all};

std::unique_ptr<PixelArray> random_pixels(RandomPrograms& random, Coverage coverage) {
    auto pixels = std::make_unique<PixelArray>();
    for (renderer::hal::Block& block : pixels->blocks) {
        for (auto& column : block.columns) {
            std::ranges::generate(column,
                                  [&] { return random.below(65536) << 16 | random.below(65536); });
        }
    }
    const auto word_of = [&](std::size_t index) -> std::uint32_t& {
        return pixels->blocks[index / renderer::hal::block_pixels]
            .columns[0][index % renderer::hal::block_pixels];
    };
    const std::size_t lone = renderer::hal::pixel_index({63, 31});
    for (std::size_t i = 0; i < region_pixels; ++i) {
        const bool is_covered =
            coverage == Coverage::all || (coverage == Coverage::one_pixel && i == lone) ||
            (coverage == Coverage::some && i / 256 % 2 == 0 && random.below(3) != 0);
        word_of(i) = (word_of(i) & ~255U) | (is_covered ? 1 + random.below(4) : 0);
    }
    return pixels;
}

/// Random enables and carries.
const WordList stir = {isa::encode({isa::Op::set_enabs, {}}),
                       isa::encode({isa::Op::mem_plus_mem, {40, 100, 31}}),
                       isa::encode({isa::Op::mem_into_enab, {150, 0, 0}})};

void run(const WordList& words, isa::Executor& executor) {
    isa::Controller controller;
    isa::run(words, executor, controller);
}
void run_stepwise(const WordList& words, isa::Executor& executor) {
    isa::Controller controller;
    isa::Sequencer sequencer(words, executor, controller);
    while (!sequencer.done()) {
        sequencer.step();
    }
}

bool same(const Fast& p, const Fast& q) {
    return std::memcmp(&p.pixels(), &q.pixels(), sizeof p.pixels()) == 0;
}

/// Counts the pixels of the window that differ in any bit.
int differing(const isa::Executor& p, const isa::Executor& q) {
    int count = 0;
    for (int i = 0; i < window.width * window.height; ++i) {
        const int x = window.x0 + i % window.width, y = window.y0 + i / window.width;
        bool equal = p.enabled(x, y) == q.enabled(x, y) && p.carry(x, y) == q.carry(x, y);
        for (std::uint32_t a = 0; a < isa::memory_bits; a += 52) {
            equal = equal && p.field(x, y, a, 52) == q.field(x, y, a, 52);
        }
        count += equal ? 0 : 1;
    }
    return count;
}

Fast::State state_of(const PixelArray& pixels) {
    return {std::make_unique<const PixelArray>(pixels), {}};
}

/// Lights of every kind: with one, two and three axes, exactly behind, without intensity.
Shading random_shading(RandomPrograms& random) {
    const auto part = [&] { return static_cast<std::uint8_t>(random.below(256)); };
    const auto axis = [&] { return static_cast<float>(random.below(2001)) / 1000 - 1; };
    Shading s;
    s.ambient = static_cast<float>(random.below(40)) / 100;
    s.specular = random.below(4) == 0 ? 0 : static_cast<float>(random.below(101)) / 100;
    s.specular_power = 1 + random.below(128);
    s.background = {part(), part(), part()};
    for (std::uint32_t i = random.below(5); i > 0; --i) {
        renderer::Light::Direction d{axis(), axis(), axis()};
        const std::uint32_t kind = random.below(6);
        d.x = kind == 0 || kind == 1 ? 0 : d.x;
        d.y = kind == 1 || kind == 2 ? 0 : d.y;
        d.z = kind == 3 ? 0 : kind == 1 ? (d.z < 0 ? -1.F : 1.F) : d.z + 0.001F;
        const bool is_dark = random.below(8) == 0;
        s.lights.push_back({d, is_dark ? 0 : 0.1F + static_cast<float>(random.below(70)) / 100});
    }
    for (std::uint32_t i = random.below(5); i > 0; --i) {
        s.surfaces.push_back({part(), part(), part()});
        s.screens.push_back({1 + random.below(16), random.below(12)});
        s.rims.push_back(static_cast<float>(random.below(4)) / 3);
    }
    if (random.below(3) == 0) {
        s.planes = random.below(static_cast<std::uint32_t>(s.surfaces.size()) + 1);
    }
    return s;
}

/// Returns every program of a region, and the end-of-region programs of passes.
std::vector<WordList> all_programs(Shading shading, RandomPrograms& random) {
    const renderer::RegionPrograms made = renderer::region_programs(shading, true);
    const std::uint32_t samples = random.below(2) == 0 ? 4 : 16;
    shading.pass = {static_cast<int>(random.below(samples)), static_cast<int>(samples)};
    std::vector<WordList> all = {made.prologue, made.end_of_region, made.depths,
                                 renderer::end_of_region(shading)};
    for (const renderer::DoorPrograms& door : made.doors) {
        all.push_back(door.shut);
        all.push_back(door.open);
    }
    return all;
}

}  // namespace

TEST_CASE("region programs, fused, leave what they leave instruction by instruction") {
    const std::uint64_t seed = test::seed_or<std::uint64_t>(first_seed);
    INFO("PXPL5_SEED=", seed);
    RandomPrograms random(seed);
    Fast stepped;
    for (int round = 0; round < 40; ++round) {
        const Coverage coverage = coverages[round % 4];
        const std::unique_ptr<PixelArray> before = random_pixels(random, coverage);
        for (const WordList& words : all_programs(random_shading(random), random)) {
            stepped.restore(state_of(*before));
            run_stepwise(stir, stepped);
            run_stepwise(words, stepped);
            test::on_every_target([&](Fast& fused) {
                fused.restore(state_of(*before));
                run(stir, fused);
                run(words, fused);
                INFO("round ", round);
                CHECK(same(stepped, fused));
            });
        }
    }
}

TEST_CASE("region programs, fused, leave what the reference leaves") {
    const std::uint64_t seed = test::seed_or<std::uint64_t>(first_seed + 1);
    INFO("PXPL5_SEED=", seed);
    RandomPrograms random(seed);
    for (int round = 0; round < 60; ++round) {
        const std::unique_ptr<PixelArray> before = random_pixels(random, coverages[1 + round % 3]);
        const Shading shading = random_shading(random);
        for (const WordList& words : all_programs(shading, random)) {
            isa::reference::Reference trusted(window);
            for (int i = 0; i < window.width * window.height; ++i) {
                const int x = window.x0 + i % window.width, y = window.y0 + i / window.width;
                const std::size_t index = renderer::hal::pixel_index(
                    {static_cast<std::size_t>(x), static_cast<std::size_t>(y)});
                for (std::uint32_t a = 0; a < isa::memory_bits; a += 52) {
                    trusted.set_field(x, y, a, 52, renderer::hal::field(*before, index, a, 52));
                }
            }
            run(stir, trusted);
            run(words, trusted);
            test::on_every_target([&](Fast& fused) {
                fused.restore(state_of(*before));
                run(stir, fused);
                run(words, fused);
                INFO("round ", round);
                CHECK(differing(trusted, fused) == 0);
            });
        }
    }
}

TEST_CASE("a piece of a region program, from anywhere to anywhere, leaves what it leaves") {
    const std::uint64_t seed = test::seed_or<std::uint64_t>(first_seed + 4);
    INFO("PXPL5_SEED=", seed);
    RandomPrograms random(seed);
    Fast stepped;
    const std::unique_ptr<PixelArray> before = random_pixels(random, Coverage::some);
    for (int round = 0; round < 200; ++round) {
        const WordList end = renderer::end_of_region(random_shading(random));
        std::vector<std::size_t> starts;  // After the skip, up to the readout.
        for (std::size_t at = 7; at < end.size(); at += isa::instruction_words(end[at])) {
            starts.push_back(at);
        }
        const auto any = [&] {
            return starts[random.below(static_cast<std::uint32_t>(starts.size()))];
        };
        const std::size_t one = any(), other = any(), from = std::min(one, other),
                          to = std::max(one, other);
        WordList words = stir;
        words.insert(words.end(), end.begin() + static_cast<std::ptrdiff_t>(from),
                     end.begin() + static_cast<std::ptrdiff_t>(to));
        stepped.restore(state_of(*before));
        run_stepwise(words, stepped);
        test::on_every_target([&](Fast& fused) {
            fused.restore(state_of(*before));
            run(words, fused);
            INFO("words ", from, " to ", to);
            CHECK(same(stepped, fused));
        });
    }
}

TEST_CASE("a stream that is nearly a region program is run as it stands") {
    const std::uint64_t seed = test::seed_or<std::uint64_t>(first_seed + 2);
    INFO("PXPL5_SEED=", seed);
    RandomPrograms random(seed);
    Fast stepped;
    const std::unique_ptr<PixelArray> before = random_pixels(random, Coverage::some);
    int tried = 0;
    while (tried < 300) {
        std::vector<WordList> all = all_programs(random_shading(random), random);
        WordList& words = all[random.below(static_cast<std::uint32_t>(all.size()))];
        const std::uint32_t at = random.below(static_cast<std::uint32_t>(words.size()));
        words[at] ^= std::uint32_t{1} << random.below(32);
        if (!isa::check(words).ok()) {
            continue;
        }
        ++tried;
        stepped.restore(state_of(*before));
        run_stepwise(words, stepped);
        test::on_every_target([&](Fast& fused) {
            fused.restore(state_of(*before));
            run(words, fused);
            INFO("word ", at, " of ", words.size());
            CHECK(same(stepped, fused));
        });
    }
}

TEST_CASE("powers of any length, more than run as one, are exact") {
    RandomPrograms random(test::seed_or<std::uint64_t>(first_seed + 3));
    // Repeats the steps of power 127.
    Shading shading;
    shading.lights = {{{0.1F, 0.2F, 0.9F}, 1}};
    shading.specular_power = 127;
    const WordList end = renderer::end_of_region(shading);
    const std::uint32_t first = isa::encode({isa::Op::mul_mem, {160, 160, 16}});
    const auto from = std::ranges::find(end, first);
    REQUIRE(from != end.end());
    REQUIRE(end.end() - from > 24);
    WordList words = stir;
    for (int i = 0; i < 7; ++i) {
        words.insert(words.end(), from, from + 24);
    }
    const std::unique_ptr<PixelArray> before = random_pixels(random, Coverage::all);
    Fast stepped;
    stepped.restore(state_of(*before));
    run_stepwise(words, stepped);
    test::on_every_target([&](Fast& fused) {
        fused.restore(state_of(*before));
        run(words, fused);
        CHECK(same(stepped, fused));
    });
}
