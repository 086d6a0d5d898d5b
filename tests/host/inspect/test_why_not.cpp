// `why-not` on expectations whose verdict follows from geometry alone.
#include <doctest/doctest.h>

#include <map>
#include <random>

#include "host/base/error.hpp"
#include "host/phantom/phantom.hpp"
#include "tests/host/inspect/recorded_sphere.hpp"
#include "tests/host/inspect/recorded_surface.hpp"

using namespace pxpl5;
using namespace pxpl5::test;
namespace inspect = host::inspect;
using inspect::Verdict;

namespace {

constexpr double isovalue = 30000.5;  ///< The torus itself.
constexpr int width = 300, height = 200;
constexpr int each = 30;  ///< Expectations of each kind.

/// A recorded torus, the frame under question, and what must be in it.
struct Asked {
    explicit Asked(const std::function<void(bus::schema::DrawFrameT&)>& change = {},
                   host::Camera camera = {{30, 25}, 1.0}, int w = width, int h = height)
        : recorded(host::make_phantom("phantom:torus"), 3, 2) {
        recorded.add_surface(isovalue);
        recorded.draw(camera, w, h, change);
        run.emplace(recorded.run());
        frame.emplace(*run, std::nullopt);
        truth = true_triangles(recorded.volume(), isovalue, recorded.view());
    }
    inspect::WhyNotFinding ask(int x, int y, const TriangleName& t) {
        return inspect::why_not(*frame, x, y, {std::array{t.i, t.j, t.k}, t.surface, t.triangle});
    }
    int random(int low, int high) { return std::uniform_int_distribution(low, high)(engine); }
    const TrueTriangle& random_triangle() {
        return truth[static_cast<std::size_t>(random(0, static_cast<int>(truth.size()) - 1))];
    }

    RecordedSurface recorded;
    std::optional<inspect::RecordedRun> run;
    std::optional<inspect::FrameInquiry> frame;
    std::vector<TrueTriangle> truth;
    std::mt19937 engine{test_seed(11)};
};

struct Box {
    double x0 = 1e9, y0 = 1e9, x1 = -1e9, y1 = -1e9;
};

/// With room for a corner that is snapped to the next step.
Box box_of(const TrueTriangle& t) {
    Box box;
    for (const glm::dvec2& p : t.p_px) {
        box = {std::min(box.x0, p.x - edge_tolerance_px), std::min(box.y0, p.y - edge_tolerance_px),
               std::max(box.x1, p.x + edge_tolerance_px),
               std::max(box.y1, p.y + edge_tolerance_px)};
    }
    return box;
}

/// Pixels whose centers lie in the box.
std::vector<glm::ivec2> centers_in(const Box& box) {
    std::vector<glm::ivec2> all;
    for (int y = static_cast<int>(std::ceil(box.y0 - 0.5)); y + 0.5 <= box.y1; ++y) {
        for (int x = static_cast<int>(std::ceil(box.x0 - 0.5)); x + 0.5 <= box.x1; ++x) {
            all.emplace_back(x, y);
        }
    }
    return all;
}

bool in_picture(glm::ivec2 p) {
    return p.x >= 0 && p.y >= 0 && p.x < width && p.y < height;
}

/// A pixel that the triangle surely covers.
std::optional<glm::ivec2> covered_pixel(const TrueTriangle& t) {
    for (const glm::ivec2 p : centers_in(box_of(t))) {
        if (in_picture(p) && t.inside(center_of(p.x, p.y)) >= edge_tolerance_px) {
            return p;
        }
    }
    return std::nullopt;
}

int region_of(double x_px, double y_px) {
    return static_cast<int>(std::floor(y_px / 128)) * 3 + static_cast<int>(std::floor(x_px / 128));
}

/// The region that holds all of the triangle; nothing if it touches several.
std::optional<int> only_region(const TrueTriangle& t) {
    const Box b = box_of(t);
    const int first = region_of(b.x0, b.y0);
    return first == region_of(b.x1, b.y1) && b.x0 >= 0 && b.x1 < width ? std::optional(first)
                                                                       : std::nullopt;
}

/// The fate of each triangle on a ray by the rule of the z-buffer alone; nothing if depths are
/// too near to each other to tell, or if it is not sure what covers the pixel.
struct Fate {
    Verdict verdict{};
    const TrueTriangle* rival = nullptr;
};
std::map<const TrueTriangle*, Fate> fates(const OnRay& ray, glm::dvec2 p) {
    std::map<const TrueTriangle*, Fate> result;
    if (ray.possible.size() != ray.sure.size()) {
        return result;
    }
    for (const TrueTriangle* a : ray.sure) {
        for (const TrueTriangle* b : ray.sure) {
            if (a != b &&
                std::abs(a->depth_at(p) - b->depth_at(p)) <= depth_doubt(*a) + depth_doubt(*b)) {
                return {};
            }
        }
    }
    const TrueTriangle* front = nullptr;
    for (const TrueTriangle* t : ray.sure) {  // In drawing order.
        if (front != nullptr && front->depth_at(p) < t->depth_at(p)) {
            result[t] = {Verdict::lost_depth_test, front};
            continue;
        }
        if (front != nullptr) {
            result[front] = {Verdict::overwritten, t};
        }
        result[t] = {Verdict::shown, nullptr};
        front = t;
    }
    return result;
}

void check_outside_edge(const inspect::WhyNotFinding& finding, const TrueTriangle& t) {
    REQUIRE(finding.verdict.verdict == Verdict::outside_edge);
    CHECK(finding.verdict.edge_value < 0);
    // Two ends of the edge, each off by a step.
    const double expected = -t.inside(center_of(finding.x, finding.y));
    CHECK(finding.verdict.distance_px == doctest::Approx(expected).epsilon(0.15));
}

/// Through the middle of a layer of cells, so that it cuts triangles.
constexpr double cut = 25.5;
void cut_in_two(bus::schema::DrawFrameT& draw) {
    draw.clip_planes.emplace_back(1.0F, 0.0F, 0.0F, static_cast<float>(-cut));  // Keeps x >= cut.
}

/// The run with some messages changed or left out, asked about an uncrossed cell.
std::string answer_on(std::vector<inspect::NodeTrace> traces) {
    const inspect::RecordedRun run(std::move(traces));
    inspect::FrameInquiry frame(run, std::nullopt);
    return inspect::answer_of(inspect::why_not(frame, 150, 100, {std::array{0, 0, 0}, 0U, {}}))
        .text();
}
std::vector<inspect::NodeTrace> without(std::vector<inspect::NodeTrace> traces, bus::Body kind) {
    for (inspect::NodeTrace& node : traces) {
        std::erase_if(node.entries, [&](const bus::trace::Entry& e) { return e.kind() == kind; });
    }
    return traces;
}

}  // namespace

TEST_SUITE("why-not") {
    TEST_CASE("a cell that the surface does not cross was never sent") {
        Asked asked;
        for (int n = 0; n < each;) {
            const TriangleName t{0, asked.random(0, 78), asked.random(0, 62), asked.random(0, 30),
                                 0};
            int inside = 0;
            for (int c = 0; c < 8; ++c) {
                inside += voxel(asked.recorded.volume(), t.i + (c & 1), t.j + (c >> 1 & 1),
                                t.k + (c >> 2)) >= isovalue;
            }
            if (inside % 8 != 0) {
                continue;
            }
            ++n;
            const auto finding = asked.ask(asked.random(0, 299), asked.random(0, 199), t);
            CHECK(finding.verdict.verdict == Verdict::not_crossed);
            CHECK(finding.verdict.cell->inside == (inside == 8 ? 255 : 0));
        }
    }

    TEST_CASE("a triangle that is elsewhere was sent elsewhere, or the pixel is outside an edge") {
        Asked asked;
        int outside = 0, elsewhere = 0;
        while (outside < each || elsewhere < each) {
            const TrueTriangle& t = asked.random_triangle();
            const auto region = only_region(t);
            if (!region || !covered_pixel(t)) {
                continue;
            }
            const glm::ivec2 p(asked.random(0, 299), asked.random(0, 199));
            INFO("pixel ", p.x, ", ", p.y, " ", inspect::to_text(t.name));
            if (region_of(p.x, p.y) != *region) {
                if (elsewhere++ < each) {
                    const auto finding = asked.ask(p.x, p.y, t.name);
                    REQUIRE(finding.verdict.verdict == Verdict::other_region);
                    CHECK(finding.verdict.regions.size() == 1);
                    CHECK(finding.verdict.regions[0].number == static_cast<unsigned>(*region));
                }
            } else if (t.inside(center_of(p.x, p.y)) < -1 && outside++ < each) {
                check_outside_edge(asked.ask(p.x, p.y, t.name), t);
            }
        }
    }

    TEST_CASE("what is hidden lost the depth test or was overwritten, by the triangle in front") {
        std::map<Verdict, int> seen;
        // Slabs are drawn from below: seen from above the far ones come first, from below the near.
        for (const double elevation_deg : {25.0, -25.0}) {
            Asked asked({}, {{30, elevation_deg}, 1.0});
            for (int n = 0; n < 2 * each;) {
                const glm::ivec2 p(asked.random(0, 299), asked.random(0, 199));
                const auto all = fates(on_ray(asked.truth, p.x, p.y), center_of(p.x, p.y));
                for (const auto& [t, fate] : all) {
                    ++n;
                    ++seen[fate.verdict];
                    INFO("pixel ", p.x, ", ", p.y, " ", inspect::to_text(t->name));
                    const auto finding = asked.ask(p.x, p.y, t->name);
                    REQUIRE(finding.verdict.verdict == fate.verdict);
                    if (fate.rival != nullptr) {
                        CHECK(finding.verdict.rival.value().cell.value().name == fate.rival->name);
                    }
                }
            }
        }
        CHECK(seen[Verdict::lost_depth_test] >= each / 2);
        CHECK(seen[Verdict::overwritten] >= each / 2);
    }

    TEST_CASE("what a clip plane cuts away was clipped") {
        Asked asked(cut_in_two);
        int whole = 0, part = 0;
        while (whole < each || part < each / 3) {
            const TrueTriangle& t = asked.random_triangle();
            const auto [low, high] =
                std::ranges::minmax({t.p_voxel[0].x, t.p_voxel[1].x, t.p_voxel[2].x});
            const auto p = covered_pixel(t);
            if (!p) {
                continue;
            }
            INFO("pixel ", p->x, ", ", p->y, " ", inspect::to_text(t.name));
            if (high < cut - 0.01 && whole < each) {
                ++whole;
                const auto finding = asked.ask(p->x, p->y, t.name);
                REQUIRE(finding.verdict.verdict == Verdict::clipped);
                CHECK(finding.verdict.plane == "clip plane 0 (1, 0, 0, -25.5)");
            } else if (low < cut - 0.1 && high > cut + 0.1 && part < each / 3) {
                // The pixel sees what is cut off, or what is left: by the point on its ray.
                const glm::dvec3 w = inspect::ray_weights(asked.frame->replayed->projection(0),
                                                          t.p_voxel, p->x, p->y);
                const double hit =
                    glm::dot(w, glm::dvec3(t.p_voxel[0].x, t.p_voxel[1].x, t.p_voxel[2].x));
                if (std::abs(hit - cut) > 0.1) {
                    ++part;
                    const Verdict verdict = asked.ask(p->x, p->y, t.name).verdict.verdict;
                    CHECK((verdict == Verdict::clipped) == (hit < cut));
                }
            }
        }
    }

    TEST_CASE("what turns its back was culled, if the surface asks for it") {
        Asked asked([](bus::schema::DrawFrameT& draw) {
            auto& s = draw.surfaces[0];
            s.mutate_cull_back(true);
        });
        for (int n = 0; n < each;) {
            const TrueTriangle& t = asked.random_triangle();
            const auto p = covered_pixel(t);
            if (!p || t.area() < 0.25) {  // Not to be turned over by snapping.
                continue;
            }
            ++n;
            INFO("pixel ", p->x, ", ", p->y, " ", inspect::to_text(t.name));
            CHECK(asked.ask(p->x, p->y, t.name).verdict.verdict == Verdict::back_face);
        }
    }

    TEST_CASE("a triangle between the pixels' centers was culled") {
        Asked asked({}, {{30, 25}, 1.0}, 75, 50);
        for (int n = 0; n < each;) {
            const TrueTriangle& t = asked.random_triangle();
            const auto near = centers_in(box_of(t));
            const bool covers = std::ranges::any_of(near, [&](glm::ivec2 p) {
                return t.inside(center_of(p.x, p.y)) > -edge_tolerance_px;
            });
            if (near.size() > 4 || covers || std::abs(t.area()) < 0.05) {
                continue;
            }
            ++n;
            INFO(inspect::to_text(t.name));
            CHECK(asked.ask(asked.random(0, 74), asked.random(0, 49), t.name).verdict.verdict ==
                  Verdict::no_pixel_center);
        }
    }

    TEST_CASE("a surface is not in the frame, not on the ray, or cut off it") {
        Asked asked(cut_in_two);
        CHECK(inspect::why_not(*asked.frame, 5, 5, {{}, 3U, {}}).verdict.verdict ==
              Verdict::not_in_frame);
        int nothing = 0, clipped = 0;
        while (nothing < each / 3 || clipped < each / 3) {
            const glm::ivec2 p(asked.random(0, 299), asked.random(0, 199));
            const OnRay ray = on_ray(asked.truth, p.x, p.y);
            const auto x_least = [](const TrueTriangle* t) {
                return std::min({t->p_voxel[0].x, t->p_voxel[1].x, t->p_voxel[2].x});
            };
            const auto finding = [&] {
                return inspect::why_not(*asked.frame, p.x, p.y, {{}, 0U, {}});
            };
            if (ray.possible.empty() && nothing < each / 3) {
                ++nothing;
                CHECK(finding().verdict.verdict == Verdict::nothing);
            } else if (!ray.sure.empty() && clipped < each / 3 &&
                       std::ranges::all_of(ray.possible,
                                           [&](auto* t) { return x_least(t) < cut - 2; })) {
                ++clipped;
                CHECK(finding().verdict.verdict == Verdict::clipped);
            }
        }
    }
}

TEST_SUITE("why-not without data") {
    TEST_CASE("slices that no trace holds are named, and a phantom is built again") {
        Asked asked;
        auto traces = without(asked.recorded.traces(), bus::Body::Slices);
        const auto with_source = [&](const std::string& source, std::uint64_t digest) {
            auto changed = traces;
            change<bus::schema::VolumeHeader>(changed, [&](bus::schema::VolumeHeaderT& h) {
                h.source = source;
                h.digest = digest;
            });
            return answer_on(changed);
        };
        host::Digest digest;
        digest.add(asked.recorded.volume().values);
        CHECK(with_source("/scans/a.nrrd", 1).find("no trace holds slices 0, 1, 2 of volume") !=
              std::string::npos);
        CHECK(with_source("/scans/a.nrrd", 1).find("no verdict") != std::string::npos);
        CHECK(with_source("phantom:torus", 1).find("has digest") != std::string::npos);
        CHECK(with_source("phantom:torus", digest.value()).find("does not pass through the cell") !=
              std::string::npos);
    }
    TEST_CASE("without the surface's isovalue there is no verdict") {
        Asked asked;
        CHECK(answer_on(without(asked.recorded.traces(), bus::Body::SetSurface))
                  .find("no trace holds the SetSurface of surface 0 (id 7, revision 1)") !=
              std::string::npos);
    }
    TEST_CASE("a region whose messages are cut off is refused by name") {
        Asked asked;
        CHECK_THROWS_AS(answer_on(without(asked.recorded.traces(), bus::Body::RegionPrograms)),
                        host::RequestError);
    }
    TEST_CASE("a GP that sent nothing of a slab is found out, and other words give no verdict") {
        Asked asked;
        const TrueTriangle* hit = nullptr;
        glm::ivec2 p;
        while (hit == nullptr) {
            p = {asked.random(0, 299), asked.random(0, 199)};
            const OnRay ray = on_ray(asked.truth, p.x, p.y);
            hit = ray.sure.empty() ? nullptr : ray.sure.front();
        }
        const auto verdict_on = [&](const auto& edit) {
            auto traces = asked.recorded.traces();
            change<bus::schema::RegionPrograms>(traces, edit);
            const inspect::RecordedRun run(std::move(traces));
            inspect::FrameInquiry frame(run, std::nullopt);
            const TriangleName& n = hit->name;
            return inspect::why_not(frame, p.x, p.y, {std::array{n.i, n.j, n.k}, 0U, n.triangle})
                .verdict.verdict;
        };
        CHECK(verdict_on([&](bus::schema::RegionProgramsT& programs) {
                  if (programs.gp == hit->name.k % 3) {
                      programs.regions.clear();
                  }
              }) == Verdict::not_sent);
        // The side table names another cell, and so nothing that the stages would send.
        CHECK(verdict_on([&](bus::schema::RegionProgramsT& programs) {
                  for (auto& region : programs.regions) {
                      for (std::size_t w = 0; w < region->words.size(); w += 34) {
                          region->words[w + 16] ^= 1;
                          region->words[w + 20] ^= 1;
                      }
                      for (auto& o : region->origins) {
                          o = bus::schema::Origin(0, 0, 1, 0, 0, 0);
                      }
                  }
              }) == Verdict::unknown);
    }
}
