// Tests pictures that are the mean of several passes: sums in the backing store, by region.
#include <algorithm>
#include <array>
#include <string>

#include "isa/contract/sample_sums.hpp"
#include "isa/reference/reference.hpp"
#include "tests/mean_pixel.hpp"
#include "tests/renderer_firmware/node_bench.hpp"
#include "tests/renderer_firmware/targets.hpp"

using namespace pxpl5;
using namespace pxpl5::test;

namespace {

/// Shadings of the passes of one picture. Colors and light differ, so that every sum differs.
renderer::Shading shading_of(std::uint32_t sample, std::uint32_t samples) {
    const auto part = [&](std::uint32_t step) {
        return static_cast<std::uint8_t>(sample == 0 ? 255 : step * sample % 256);
    };
    renderer::Shading s;
    s.ambient = 1;
    s.background = {part(77), part(91), part(113)};
    s.surfaces = {{part(31), part(201), part(150)}, {part(3), part(5), part(7)}};
    s.pass = {static_cast<int>(sample), static_cast<int>(samples)};
    return s;
}

/// The segments of a region. Adjacent slots have different sheets, and one slot has none.
std::vector<renderer::Segment> segments_of(std::size_t slot, const WordList& words) {
    return slot % 3 == 2 ? std::vector<renderer::Segment>{}
                         : std::vector<renderer::Segment>{{0, 0, 0, words, 0}};
}

/// A sheet of the slot's surface over half of the region.
WordList half_sheet(std::size_t slot) {
    test::TrianglePlanes t;
    put_edges({0, 0}, {2048, 0}, {0, 2048}, t);
    t.z[2] = 5000 << 8;
    t.normals[2][2] = 500 << 16;
    t.surface = 1 + static_cast<std::uint32_t>(slot % 2);
    WordList words;
    append(t, words);
    return words;
}

WordList drawn(isa::Executor& executor, const renderer::Shading& shading, std::size_t slot) {
    const WordList words = half_sheet(slot);
    renderer::RegionPrograms programs = renderer::region_programs(shading);
    if (shading.pass.samples > 1) {
        programs.end_of_region =
            renderer::at_slot(programs.end_of_region, shading.pass.samples, slot);
    }
    WordList pixels;
    executor.set_readout([&](renderer::Words read) { pixels.assign(read.begin(), read.end()); });
    const renderer::RegionResult result =
        draw_region(executor, renderer::region_frame(programs), segments_of(slot, words));
    CHECK(result.faults.empty());
    executor.set_readout({});
    return pixels;
}

std::array<std::size_t, 4> slots_of(std::uint32_t samples) {
    return {0, 1, 2, isa::max_summed_regions(samples) - 1};
}

/// The readout of each pass, for every slot.
std::vector<std::vector<WordList>> singles(std::uint32_t samples) {
    std::vector<std::vector<WordList>> all;
    for (const std::size_t slot : slots_of(samples)) {
        std::vector<WordList>& pictures = all.emplace_back();
        for (std::uint32_t k = 0; k < samples; ++k) {
            renderer::fast::Fast alone;
            renderer::Shading single = shading_of(k, samples);
            single.pass = {};
            pictures.push_back(drawn(alone, single, slot));
        }
    }
    return all;
}

bus::Payload pass(std::uint32_t frame, std::uint8_t sample,
                  const std::vector<std::uint16_t>& assignment) {
    return begin(frame, assignment, {.sample = sample, .samples = 4});
}

}  // namespace

TEST_CASE("the last of several passes reads out the mean of what each alone would, halves up") {
    for (const std::uint32_t samples : {few_samples, many_samples}) {
        CAPTURE(samples);
        const auto expected = singles(samples);
        test::on_every_target([&](renderer::fast::Fast& fast) {
            std::vector<WordList> pixels(4);
            for (std::uint32_t k = 0; k < samples; ++k) {
                for (std::size_t i = 0; i < 4; ++i) {  // The regions of one Renderer alternate.
                    CHECK(pixels[i].empty());
                    fast.reset_pixels();
                    pixels[i] = drawn(fast, shading_of(k, samples), slots_of(samples)[i]);
                }
            }
            for (std::size_t i = 0; i < 4; ++i) {
                REQUIRE(pixels[i].size() == tile);
                std::size_t wrong = 0;
                for (std::size_t p = 0; p < tile; ++p) {
                    wrong += pixels[i][p] == mean_pixel(expected[i], p) ? 0 : 1;
                }
                CHECK(wrong == 0);
            }
        });
    }
}

TEST_CASE("the reference executor sums as the fast one does") {
    for (const std::uint32_t samples : {few_samples, many_samples}) {
        isa::reference::Reference trusted({62, 62, 4, 4});
        const auto expected = singles(samples);
        WordList pixels;
        for (std::uint32_t k = 0; k < samples; ++k) {
            pixels = drawn(trusted, shading_of(k, samples), slots_of(samples)[3]);
        }
        for (std::size_t y = 62; y < 66; ++y) {
            for (std::size_t x = 62; x < 66; ++x) {
                CHECK(pixels.at(y * 128 + x) == mean_pixel(expected[3], y * 128 + x));
            }
        }
    }
}

TEST_CASE("over 16 passes a transparent surface has its share of every pixel") {
    for (const std::uint32_t pattern : {0U, 1U, 2U, 3U, 11U}) {
        for (const std::uint32_t opacity : {1U, 4U, 7U, 12U, 15U}) {
            CAPTURE(pattern);
            CAPTURE(opacity);
            for (const std::uint32_t samples : {few_samples, many_samples}) {
                if (opacity % (16 / samples) != 0) {
                    continue;  // Four passes give only quarters.
                }
                renderer::fast::Fast fast;
                WordList pixels;
                for (std::uint32_t k = 0; k < samples; ++k) {
                    renderer::Shading s;
                    s.ambient = 1;
                    s.background = {0, 100, 200};
                    s.surfaces = {{160, 20, 200}};
                    s.screens = {{opacity, pattern}};
                    s.pass = {static_cast<int>(k), static_cast<int>(samples)};
                    const WordList words = sheet(0, 5000);
                    fast.reset_pixels();
                    fast.set_readout(
                        [&](renderer::Words read) { pixels.assign(read.begin(), read.end()); });
                    const renderer::RegionPrograms programs = renderer::region_programs(s);
                    draw_region(fast, renderer::region_frame(programs), {{0, 0, 0, words, 0}});
                }
                const std::uint32_t red = (160 * opacity + 8) / 16;
                const std::uint32_t green = (20 * opacity + 100 * (16 - opacity) + 8) / 16;
                CHECK(pixels == WordList(tile, red | green << 8 | 200U << 16));
            }
        }
    }
}

TEST_CASE("a Renderer sends the mean with the last pass, and no pixels before") {
    RendererBench bench(1, 2, 1);
    for (std::uint8_t k = 0; k < 4; ++k) {
        bench.take(first_gp, pass(7U + k, k, {1, 0, 1}));
        // One of four passes shows the sheet in region 2.
        bench.from_gp(0, k == 1 ? programs(7U + k, 0, {{2, {{0, 3, sheet(0, 5000)}}}})
                                : programs(7U + k, 0, {}));
        bench.work();
    }
    CHECK(bench.faults().empty());
    const auto frames = bench.frames();
    REQUIRE(frames.size() == 4);
    for (std::size_t k = 0; k < 3; ++k) {
        CHECK(frames[k]->tiles()->size() == 2);
        CHECK(frames[k]->pixels()->size() == 0);
    }
    REQUIRE(frames[3]->pixels()->size() == 2 * tile);
    CHECK(is_all(*frames[3], 0, background));
    // (200 + 3 * 10) / 4 is 57.5, (100 + 3 * 20) / 4 is 40, (50 + 3 * 30) / 4 is 35.
    CHECK(is_all(*frames[3], 1, 58 | 40 << 8 | 35 << 16));
}

TEST_CASE("a pass whose sums are not there is a fault, and the next picture is drawn") {
    const auto draw = [](RendererBench& bench, const bus::Payload& payload, std::uint32_t frame) {
        bench.take(first_gp, payload);
        bench.from_gp(0, programs(frame, 0, {}));
        bench.work();
    };
    RendererBench bench(1, 1, 0);
    draw(bench, pass(1, 0, {0}), 1);
    draw(bench, pass(3, 1, {0}), 3);  // Frame 2 is missing.
    CHECK(
        bench.faults().back() ==
        "lost_message: frame 3, sample 2 of 4: the stored sums are those of sample 1 of 4 of frame "
        "1");
    draw(bench, pass(4, 0, {0}), 4);
    draw(bench, begin(5, {0}), 5);  // A picture between two passes.
    draw(bench, pass(6, 1, {0}), 6);
    CHECK(bench.faults().back() == "lost_message: frame 6, sample 2 of 4: no sums are stored");
    draw(bench, pass(7, 0, {0}), 7);
    draw(bench, pass(8, 1, {0, 0}), 8);
    CHECK(bench.faults().back().find("those of 1 other regions, not of the 2") !=
          std::string::npos);
    CHECK(bench.faults().size() == 3);
    for (std::uint8_t k = 0; k < 4; ++k) {
        draw(bench, pass(9U + k, k, {0}), 9U + k);
    }
    CHECK(bench.faults().size() == 3);
    CHECK(is_all(*bench.frames().back(), 0, background));
}

TEST_CASE("a stream may not touch the backing store while it holds sums") {
    const WordList reads = {isa::encode({isa::Op::set_enabs, {}}),
                            isa::encode({isa::Op::bs_read, {128, 5, 0}}),
                            isa::encode({isa::Op::bs_wait, {}})};
    for (const bool is_pass : {false, true}) {
        RendererBench bench(1, 1, 0);
        bench.take(first_gp, is_pass ? pass(1, 0, {0}) : begin(1, {0}));
        bench.from_gp(0, programs(1, 0, {{0, {{0, 3, reads}}}}));
        bench.work();
        CHECK(bench.frames().size() == 1);
        REQUIRE(bench.faults().size() == (is_pass ? 1 : 0));
        if (is_pass) {
            CHECK(bench.faults()[0].find("it uses the backing store") != std::string::npos);
        }
    }
}

TEST_CASE("a Renderer is not given more regions than it has room to sum") {
    RendererBench bench(1, 1, 0);
    CHECK(bench.refused(first_gp, pass(1, 0, std::vector<std::uint16_t>(64, 0))) == "taken");
    CHECK(bench.refused(first_gp, begin(2, std::vector<std::uint16_t>(64, 0),
                                        {.sample = 0, .samples = 16})) == "taken");
    const schema::BeginFrameT many = [] {
        // A picture of 128 x 8 regions would be too wide; this one has 2 rows of 33.
        schema::BeginFrameT body;
        schema::GetMessage(begin(3, std::vector<std::uint16_t>(33, 0), {.sample = 0, .samples = 16})
                               .bytes()
                               .data())
            ->body_as_BeginFrame()
            ->UnPackTo(&body);
        body.draw->height = 256;
        body.assignment.assign(66, 0);
        return body;
    }();
    CHECK(bench.refused(first_gp, bus::pack(many)) ==
          "frame 3: Renderer 0 has 66 regions, but can sum 16 samples of at most 64");
}
