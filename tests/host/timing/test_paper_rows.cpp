#include <doctest/doctest.h>

#include <algorithm>

#include "host/phantom/phantom.hpp"
#include "host/timing/paper_rows.hpp"

namespace pxpl5::host::timing {

TEST_CASE("each of the paper's results is that of a phantom's surface, and of a measured volume") {
    REQUIRE(paper_rows().size() == 5);
    REQUIRE(data_rows().size() == 5);
    for (std::size_t i = 0; i < paper_rows().size(); ++i) {
        const PaperRow& row = paper_rows()[i];
        CAPTURE(std::string(row.volume));
        const auto surfaces = suggested_surfaces(row.volume);
        const auto named = std::find_if(surfaces.begin(), surfaces.end(),
                                        [&row](const auto& s) { return s.name == row.surface; });
        REQUIRE(named != surfaces.end());
        CHECK(row.paper.triangles == named->paper_triangles);
        CHECK(data_rows()[i].paper.triangles == row.paper.triangles);
        CHECK(data_rows()[i].paper.built_ms == row.paper.built_ms);
        CHECK(data_rows()[i].paper.frames_per_s == row.paper.frames_per_s);
    }
}

TEST_CASE("two results on phantoms, and all on measured volumes, are held back from fitting") {
    CHECK(std::ranges::count(paper_rows(), true, &PaperRow::held_back) == 2);
    CHECK(std::ranges::count(data_rows(), true, &PaperRow::held_back) == 5);
}

}  // namespace pxpl5::host::timing
