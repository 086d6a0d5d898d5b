// `why` and `why-not` in sets of slabs, on unevenly spaced slices, and behind a mask.
#include <doctest/doctest.h>

#include "host/inspect/why/why_not.hpp"
#include "host/phantom/phantom.hpp"
#include "tests/host/inspect/ray_check.hpp"

using namespace pxpl5;
using namespace pxpl5::test;
using inspect::Verdict;

namespace {

constexpr double isovalue = 30000.5;

/// A torus in sets of three slabs, its slices at places that swing about their own.
host::Volume uneven_torus() {
    host::Volume volume = host::make_phantom("phantom:torus");
    volume.slabs_per_set = 3;
    for (int z = 0; z < volume.nz; ++z) {
        volume.slice_places.push_back(z + 0.3 * std::sin(1.3 * z));
    }
    return volume;
}

}  // namespace

TEST_SUITE("why/mask") {
    TEST_CASE("sets of three slabs and uneven slices: a pixel's cell is the one its ray meets") {
        RecordedSurface recorded(uneven_torus(), 3, 2);
        recorded.add_surface(isovalue);
        recorded.draw({{30, 25}, 1.0}, 300, 200);
        check_pixels(recorded, isovalue, 100);
    }

    TEST_CASE("a triangle behind a mask is hidden by it, in the frames after it alone") {
        RecordedSurface recorded(uneven_torus(), 2, 2);
        recorded.add_surface(isovalue);
        recorded.draw({{0, 90}, 1.0}, 200, 200);
        TriangleName top;
        {
            const inspect::RecordedRun run = recorded.run();
            inspect::FrameInquiry frame(run, 0);
            const inspect::WhyFinding finding = inspect::why(frame, 100, 42);
            REQUIRE(finding.shown() != nullptr);
            top = finding.shown()->cell.value().name;
        }
        recorded.mask([&](std::uint32_t slab, std::size_t) {
            return slab == static_cast<std::uint32_t>(top.k);
        });
        recorded.draw({{0, 90}, 1.0}, 200, 200);

        const inspect::RecordedRun run = recorded.run();
        const inspect::Expectation cell{std::array{top.i, top.j, top.k}, {}, top.triangle};
        inspect::FrameInquiry before(run, 0), after(run, 1);
        CHECK(inspect::why_not(before, 100, 42, cell).verdict.verdict == Verdict::shown);
        const inspect::WhyNotFinding hidden = inspect::why_not(after, 100, 42, cell);
        CHECK(hidden.verdict.verdict == Verdict::masked);
        const std::string text = inspect::answer_of(hidden).text();
        CHECK_MESSAGE(text.find("is hidden by a mask") != std::string::npos, text);
        // What shows instead is whole, and its slab is drawn again word for word.
        REQUIRE(hidden.shown.shown() != nullptr);
        CHECK(hidden.shown.shown()->cell.value().doubt == "");
        CHECK(hidden.shown.shown()->cell.value().name.k != top.k);
    }

    TEST_CASE("a surface that is hidden whole is hidden by a mask where it would be") {
        RecordedSurface recorded(uneven_torus(), 2, 2);
        recorded.add_surface(isovalue);
        recorded.mask([](std::uint32_t, std::size_t) { return true; });
        recorded.draw({{0, 90}, 1.0}, 200, 200);
        const inspect::RecordedRun run = recorded.run();
        inspect::FrameInquiry frame(run, std::nullopt);
        CHECK(inspect::why_not(frame, 100, 42, {{}, 0U, {}}).verdict.verdict == Verdict::masked);
        CHECK(inspect::why_not(frame, 100, 100, {{}, 0U, {}}).verdict.verdict == Verdict::nothing);
    }
}
