// Asks `why` about random pixels and compares with the pixel's ray: for tests of it on any volume.
#pragma once

#include <doctest/doctest.h>

#include <random>
#include <string>

#include "tests/host/inspect/recorded_surface.hpp"

namespace pxpl5::test {

namespace inspect = host::inspect;

/// Whether `name` may be what is nearest on the ray: it covers the pixel, perhaps by the width of a
/// snapping step, and nothing that surely covers the pixel is surely nearer.
inline bool may_be_nearest(const OnRay& ray, const inspect::TriangleName& name, glm::dvec2 p) {
    const auto found = std::ranges::find(ray.possible, name, &TrueTriangle::name);
    if (found == ray.possible.end()) {
        return false;
    }
    const TrueTriangle& named = **found;
    return std::ranges::all_of(ray.sure, [&](const TrueTriangle* t) {
        return t->depth_at(p) + depth_doubt(*t) >= named.depth_at(p) - depth_doubt(named);
    });
}

/// How many triangles might be the one that the pixel shows.
inline std::ptrdiff_t candidates(const OnRay& ray, glm::dvec2 p) {
    return std::ranges::count_if(
        ray.possible, [&](const TrueTriangle* t) { return may_be_nearest(ray, t->name, p); });
}

inline void check_cell(const inspect::CellFacts& cell, const host::Volume& volume,
                       double isovalue) {
    REQUIRE(cell.unknown == "");
    CHECK(cell.doubt == "");
    unsigned inside = 0;
    for (unsigned c = 0; c < 8; ++c) {
        const double value = voxel(volume, cell.name.i + static_cast<int>(c & 1),
                                   cell.name.j + static_cast<int>(c >> 1 & 1),
                                   cell.name.k + static_cast<int>(c >> 2));
        CHECK(cell.values[c] == value);
        inside |= (value >= isovalue ? 1U : 0U) << c;
    }
    CHECK(inside != 0);
    CHECK(inside != 255);  // The values straddle the isovalue.
    CHECK(cell.origin.inside == inside);
    for (const inspect::CornerFacts& corner : cell.corners) {
        if (!corner.is_center) {
            CHECK((corner.value_0 < isovalue) != (corner.value_1 < isovalue));
            CHECK(corner.value_0 + corner.fraction * (corner.value_1 - corner.value_0) ==
                  doctest::Approx(isovalue));
        }
    }
}

/// `count` random pixels that the surface covers, each against the ray.
/// view_y_px  Where the view that `recorded` knows begins in the picture.
inline void check_pixels(RecordedSurface& recorded, double isovalue, int count, int view_y_px = 0) {
    std::mt19937 random(test_seed(5));
    const TrueView& view = recorded.view();
    const auto truth = true_triangles(recorded.volume(), isovalue, view);
    const inspect::RecordedRun run = recorded.run();
    inspect::FrameInquiry frame(run, std::nullopt);
    std::uniform_int_distribution<int> column(0, view.width - 1), row(0, view.height - 1);
    int sole = 0, hidden = 0;
    for (int n = 0; n < count;) {
        const int x = column(random), y = row(random);
        const OnRay ray = on_ray(truth, x, y);
        const inspect::WhyFinding finding = inspect::why(frame, x, y + view_y_px);
        INFO("pixel ", x, ", ", y);
        CHECK(finding.history.sent.value() % (1U << 24) == finding.history.color % (1U << 24));
        if (finding.shown() == nullptr) {
            CHECK(ray.sure.empty());
            continue;
        }
        ++n;
        REQUIRE(finding.shown()->cell);
        const inspect::CellFacts& cell = *finding.shown()->cell;
        CAPTURE(inspect::to_text(cell.name));
        CHECK(may_be_nearest(ray, cell.name, center_of(x, y)));
        check_cell(cell, recorded.volume(), isovalue);
        // The point where the ray meets the triangle projects to the pixel's center.
        const glm::dvec3 px = view.to_px(cell.hit_voxel);
        CHECK(px.x == doctest::Approx(x + 0.5).epsilon(1e-6));
        CHECK(px.y == doctest::Approx(y + 0.5).epsilon(1e-6));
        const int set = cell.name.k / recorded.volume().slabs_per_set;
        CHECK(finding.shown()->gp == static_cast<unsigned>(set) % run.gp_count());
        sole += candidates(ray, center_of(x, y)) == 1 ? 1 : 0;
        hidden += ray.sure.size() > 1 ? 1 : 0;
    }
    // The tolerances leave the answer open only at edges.
    MESSAGE(sole, " of ", count, " pixels have one possible answer, ", hidden, " hide something");
    CHECK(sole >= count / 2);
    CHECK(hidden >= count / 6);
}

}  // namespace pxpl5::test
