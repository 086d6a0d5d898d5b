// A transparent surface on a whole machine, and what the tools say about it.
#include <doctest/doctest.h>

#include <set>

#include "host/inspect/listing/run_stats.hpp"
#include "host/inspect/replay/replay.hpp"
#include "host/inspect/replay/scoped_reference.hpp"
#include "host/inspect/step/step_view.hpp"
#include "host/inspect/why/why_not.hpp"
#include "host/phantom/phantom.hpp"
#include "isa/contract/triangle_shape.hpp"
#include "tests/host/inspect/recorded_surface.hpp"

using namespace pxpl5;
using namespace pxpl5::test;
namespace inspect = host::inspect;

namespace {

constexpr int width = 300, height = 200;
constexpr double outer = 0.5, inner = 1000.5;  // Radii 30 and 20 mm.
constexpr std::uint32_t bayer[4][4] = {
    {0, 8, 2, 10}, {12, 4, 14, 6}, {3, 11, 1, 9}, {15, 7, 13, 5}};

struct Shown {
    std::vector<std::uint32_t> pixels, depths;
    bool operator==(const Shown&) const = default;
};

Shown shown_by(const inspect::RecordedRun& run, std::uint32_t number) {
    const inspect::RecordedFrame frame = run.frame(number);
    const auto& done = *frame.done.at(0).as<bus::schema::FrameDone>();
    return {{done.pixels()->begin(), done.pixels()->end()},
            {done.depths()->begin(), done.depths()->end()}};
}

/// A ball in a ball: frame 0 the outer one alone, frame 1 the inner one alone, frame 2 both, the
/// outer one in `opacity` sixteenths; frame 3 both with the list turned round.
struct Balls : RecordedSurface {
    Balls(int gps, int renderers, std::uint8_t opacity)
        : RecordedSurface(host::make_phantom("phantom:sphere"), gps, renderers) {
        add_surface(outer);
        add_surface(inner);
        for (int frame = 0; frame < 4; ++frame) {
            draw({{30, 25}, 1.0}, width, height, [&](bus::schema::DrawFrameT& draw) {
                draw.read_back = draw.read_depths = true;
                draw.surfaces[1].mutable_color() = bus::schema::Rgb(10, 20, 240);
                if (frame < 2) {
                    draw.surfaces.erase(draw.surfaces.begin() + (1 - frame));
                    return;
                }
                draw.surfaces[0].mutate_opacity(opacity);
                if (frame == 3) {
                    std::swap(draw.surfaces[0], draw.surfaces[1]);
                }
            });
        }
    }
};

}  // namespace

TEST_SUITE("transparent surfaces") {
    TEST_CASE("a pixel shows the outer ball where the pattern says so, else the inner one") {
        const Balls recorded(3, 2, 6);
        const inspect::RecordedRun run = recorded.run();
        const Shown skin = shown_by(run, 0), bone = shown_by(run, 1), both = shown_by(run, 2);
        int through = 0;
        for (int y = 0; y < height; ++y) {
            for (int x = 0; x < width; ++x) {
                const auto at = static_cast<std::size_t>(y * width + x);
                const bool of_skin = bayer[y % 4][x % 4] < 6;
                const std::uint32_t field = both.depths[at] & 0xFF;
                if (of_skin && (skin.depths[at] & 0xFF) != 0) {
                    REQUIRE(both.depths[at] == skin.depths[at]);
                    REQUIRE(both.pixels[at] == skin.pixels[at]);
                } else {
                    REQUIRE((both.depths[at] >> 8) == (bone.depths[at] >> 8));
                    REQUIRE(both.pixels[at] == bone.pixels[at]);
                    REQUIRE(field == ((bone.depths[at] & 0xFF) != 0 ? 2 : 0));
                    through += field == 2 ? 1 : 0;
                }
            }
        }
        CHECK(through > 2000);
    }
    TEST_CASE("the picture does not depend on the machine") {
        const Balls one(1, 1, 11), many(4, 3, 11);
        for (const std::uint32_t frame : {2U, 3U}) {
            CHECK(shown_by(one.run(), frame) == shown_by(many.run(), frame));
        }
    }
    TEST_CASE("in the other order of the list the same pixels show the same") {
        const inspect::RecordedRun run = Balls(2, 1, 8).run();
        const Shown skin = shown_by(run, 0), turned = shown_by(run, 3);
        for (int y = 0; y < height; ++y) {
            for (int x = 0; x < width; ++x) {
                const auto at = static_cast<std::size_t>(y * width + x);
                if ((skin.depths[at] & 0xFF) != 0) {
                    REQUIRE(((turned.depths[at] & 0xFF) == 2) == (bayer[y % 4][x % 4] < 8));
                }
            }
        }
    }
    TEST_CASE("replay agrees on both executors, and statistics with what Renderers told") {
        const inspect::RecordedRun run = Balls(2, 2, 8).run();
        inspect::ReplayOptions options;
        options.executors = inspect::parse_executors("both");
        inspect::SelectionText selection;
        selection.frame = {"2"};
        selection.region = {"1,0"};
        options.selection = inspect::parse_selection(selection);
        const inspect::ReplayReport report = inspect::replay(run, options);
        CHECK(report.agrees());
        CHECK(report.compared() == 2);
        const inspect::RunStats stats = inspect::stats_of(run, {});
        CHECK(stats.differences.empty());
        CHECK(stats.told == stats.regions);
    }
    TEST_CASE("doors and depths are parts with names of their own, which lead back to them") {
        const inspect::RecordedRun run = Balls(2, 1, 8).run();
        const inspect::RecordedFrame frame = run.frame(2);
        const renderer::RegionPlan& plan = frame.regions.at(1).plan;
        std::set<std::string> names;
        for (std::size_t part = 0; part < plan.parts.size(); ++part) {
            const std::string name = inspect::to_text(plan, {part, 0});
            CHECK(names.insert(name).second);
            CHECK(inspect::address_of(plan, name) == inspect::Address{part, 0});
        }
        for (const char* name : {"shut-door surface 0+0", "open-door surface 0+0", "depths+0"}) {
            CHECK(names.contains(name));
        }
    }
    TEST_CASE("why takes a door's stores for nobody's, and why-not knows a shut door") {
        const inspect::RecordedRun run = Balls(2, 1, 8).run();
        inspect::FrameInquiry frame(run, 2);
        int open = 0, shut = 0;
        for (int n = 0; n < 40; ++n) {
            const int x = 130 + n % 8, y = 90 + n / 8;
            INFO("pixel ", x, ", ", y);
            const bool is_shut = bayer[y % 4][x % 4] >= 8;
            const inspect::WhyFinding finding = inspect::why(frame, x, y);
            const inspect::PixelHistory& h = finding.history;
            REQUIRE(finding.shown() != nullptr);
            CHECK(finding.shown()->surface == (is_shut ? 1 : 0));
            CHECK(finding.shown()->cell->name.surface == (is_shut ? 1 : 0));
            CHECK(h.shut_surfaces == (is_shut ? std::vector{0U} : std::vector<std::uint32_t>{}));
            CHECK(h.sent.value() == h.color);
            const std::string sentence = inspect::sentence_of(finding);
            CHECK(sentence.find(", the nearest of ") != std::string::npos);
            CHECK((sentence.find("of transparent surfaces whose stipple masks hide") !=
                   std::string::npos) == is_shut);
            for (std::size_t v = 0; v < h.visits.size(); ++v) {
                const bool is_outer = finding.facts[v].surface == 0;
                CHECK(h.visits[v].surface == finding.facts[v].surface);
                CHECK(h.is_shut_out(h.visits[v]) == (is_outer && is_shut));
                CHECK((h.visits[v].after.z == 0) == (is_outer && is_shut));
            }
            const auto verdict = inspect::why_not(frame, x, y, {{}, 0U, {}}).verdict.verdict;
            CHECK(verdict == (is_shut ? inspect::Verdict::shut_out : inspect::Verdict::shown));
            (is_shut ? shut : open) += 1;
        }
        CHECK(open == 20);
        CHECK(shut == 20);
    }
    TEST_CASE("a visit ends before the door opens: what the door stores is not in it") {
        RecordedSurface recorded(host::make_phantom("phantom:sphere"), 2, 1);
        recorded.add_surface(outer);
        // So near that the last triangle of each region covers pixels.
        recorded.draw({{30, 25}, 5.0}, width, height,
                      [](bus::schema::DrawFrameT& draw) { draw.surfaces[0].mutate_opacity(1); });
        const inspect::RecordedRun run = recorded.run();
        const inspect::RecordedFrame frame = run.frame(0);
        int shut = 0;
        for (const auto& [number, region] : frame.regions) {
            const auto& parts = region.plan.parts;
            const auto opens =
                std::ranges::find(parts, PartKind::open_door, &renderer::RegionPlan::Part::kind);
            if (opens == parts.end()) {
                continue;
            }
            // The last triangle behind the door, on the pixels of its box.
            const auto last_part = static_cast<std::size_t>(opens - parts.begin()) - 1;
            const renderer::Words words = parts[last_part].segment.words;
            const isa::reference::Window box =
                inspect::triangle_box(words.data() + words.size() - isa::triangle::word_count);
            for (int i = 0; i < box.width * box.height; ++i) {
                const int x = region.place.x0_px + box.x0 + i % box.width,
                          y = region.place.y0_px + box.y0 + i / box.width;
                const inspect::PixelHistory h = inspect::history_of(frame, region, x, y);
                for (const inspect::PixelVisit& visit : h.visits) {
                    if (h.primitives[visit.primitive].part == last_part &&
                        visit.primitive + 1 == h.primitives.size()) {
                        CHECK((visit.after.z == 0) == (bayer[y % 4][x % 4] >= 1));
                        shut += visit.after.z == 0 ? 1 : 0;
                    }
                }
            }
        }
        CHECK(shut > 0);
    }
    TEST_CASE("slabs in gaps are drawn by the choice that names them, with a color of their own") {
        host::Volume volume = host::make_phantom("phantom:sphere");
        volume.gap_slabs = {20, 21, 30};
        RecordedSurface recorded(volume, 3, 1);
        recorded.add_surface(outer);
        const auto draw = [&](std::vector<SlabChoice> choices,
                              std::uint8_t opacity = full_opacity) {
            recorded.draw({{30, 5}, 1.0}, width, height, [&](bus::schema::DrawFrameT& frame) {
                frame.read_back = frame.read_depths = true;
                const bus::schema::SurfaceDraw first = frame.surfaces[0];
                frame.surfaces.clear();
                for (const SlabChoice choice : choices) {
                    frame.surfaces.push_back(first);
                    frame.surfaces.back().mutate_slabs(choice);
                    frame.surfaces.back().mutate_opacity(opacity);
                }
            });
        };
        draw({SlabChoice::all});
        draw({SlabChoice::outside_gaps, SlabChoice::in_gaps});
        draw({SlabChoice::in_gaps});
        draw({SlabChoice::outside_gaps, SlabChoice::in_gaps}, 4);
        const inspect::RecordedRun run = recorded.run();
        const Shown all = shown_by(run, 0), tinted = shown_by(run, 1);
        inspect::FrameInquiry inquiry(run, 1), gaps(run, 2);
        int in_gaps = 0, left_out = 0;
        for (std::size_t at = 0; at < all.depths.size(); ++at) {
            REQUIRE((all.depths[at] >> 8) == (tinted.depths[at] >> 8));
            const std::uint32_t field = tinted.depths[at] & 0xFF;
            REQUIRE((field != 0) == ((all.depths[at] & 0xFF) != 0));
            if (field == 0 || at % 101 != 0) {
                continue;
            }
            const int x = static_cast<int>(at) % width, y = static_cast<int>(at) / width;
            const inspect::WhyFinding finding = inspect::why(inquiry, x, y);
            const int k = finding.shown()->cell.value().name.k;
            CHECK((field == 2) == (k == 20 || k == 21 || k == 30));
            in_gaps += field == 2 ? 1 : 0;
            if (field == 1 && left_out < 3) {
                ++left_out;
                const TriangleName& n = finding.shown()->cell->name;
                const auto verdict =
                    inspect::why_not(gaps, x, y, {std::array{n.i, n.j, n.k}, 0U, n.triangle});
                CHECK(verdict.verdict.verdict == inspect::Verdict::not_sent);
                CHECK(verdict.verdict.reason ==
                      "the frame draws this surface in gaps between slices only, and slab " +
                          std::to_string(k) + " is not in one");
            }
        }
        CHECK(in_gaps > 5);
        CHECK(left_out == 3);
        // Transparent, both parts of the surface have one pattern.
        const Shown thin = shown_by(run, 3);
        for (std::size_t at = 0; at < all.depths.size(); ++at) {
            const bool is_open = bayer[at / width % 4][at % width % 4] < 4;
            REQUIRE((thin.depths[at] & 0xFF) == (is_open ? tinted.depths[at] & 0xFF : 0));
        }
    }
}
