// The GP as a node: what a frame asked of it, counted.
#include <doctest/doctest.h>

#include <algorithm>
#include <map>
#include <set>
#include <tuple>

#include "isa/contract/triangle_shape.hpp"
#include "tests/gp_firmware/node/support.hpp"

using namespace pxpl5;
using namespace pxpl5::test;

namespace {

/// A picture of a single region: each triangle is in it once, or culled.
schema::DrawFrameT counted_frame() {
    schema::DrawFrameT draw = draw_frame(9, 1);
    draw.width = draw.height = 128;
    draw.counts = true;
    return draw;
}

const schema::FrameCounts& counts_of(const LoneGp& gp) {
    const auto all = gp.box.of<schema::FrameCounts>();
    REQUIRE(all.size() == 1);
    return *all[0];
}

struct Sums {
    std::uint32_t primitives = 0, culled = 0;
};
Sums sums_of(const schema::FrameCounts& counts) {
    Sums sums;
    for (const schema::DrawnSlab* slab : *counts.drawn()) {
        sums.primitives += slab->primitives();
        sums.culled += slab->culled();
    }
    return sums;
}

}  // namespace

TEST_SUITE("gp/node counts") {
    TEST_CASE("a GP tells the host what it drew, before its programs, and only if it is asked") {
        for (const bool asked : {true, false}) {
            schema::DrawFrameT draw = counted_frame();
            draw.counts = asked;
            const auto gps = run_machine({3, 2}, draw);
            for (const auto& gp : gps) {
                const auto& sent = gp->box.sent;
                const auto told = std::ranges::find_if(
                    sent, [](const Sent& s) { return s.as<schema::FrameCounts>() != nullptr; });
                const auto programs = std::ranges::find_if(
                    sent, [](const Sent& s) { return s.as<schema::RegionPrograms>() != nullptr; });
                CHECK((told != sent.end()) == asked);
                if (asked) {
                    CHECK(told < programs);
                    CHECK(told->to == bus::host_id);
                    CHECK(counts_of(*gp).frame() == 9);
                    CHECK(counts_of(*gp).parts()->size() == 0);
                }
            }
        }
    }

    TEST_CASE("drawn are the slabs that hold triangles, whole, and emitted is what is not culled") {
        for (const bool cull_back : {false, true}) {
            schema::DrawFrameT draw = counted_frame();
            draw.surfaces[0] = schema::SurfaceDraw(4, 1, schema::Rgb(), cull_back, SlabChoice::all,
                                                   full_opacity, 0, 0);
            const auto gps = run_machine({3, 2}, draw);
            Sums all;
            std::uint32_t emitted = 0;
            for (const auto& gp : gps) {
                std::map<std::uint32_t, std::uint32_t> built, drawn;
                for (const auto* slab : *gp->box.of<schema::SurfaceBuilt>()[0]->slabs()) {
                    if (slab->triangles() > 0) {
                        built[slab->slab()] = slab->triangles();
                    }
                }
                for (const auto* slab : *counts_of(*gp).drawn()) {
                    CHECK(slab->surface() == 0);
                    drawn[slab->slab()] = slab->primitives();
                }
                CHECK(drawn == built);
                const auto* programs = gp->box.of<schema::RegionPrograms>()[0];
                const Sums sums = sums_of(counts_of(*gp));
                CHECK(sums.primitives == programs->triangles_in());
                CHECK(sums.primitives - sums.culled == programs->triangles_out());
                CHECK(counts_of(*gp).words() ==
                      programs->triangles_out() * isa::triangle::word_count);
                all.primitives += sums.primitives;
                emitted += programs->triangles_out();
            }
            const auto whole = run_machine({1, 1}, draw);
            const Sums sums = sums_of(counts_of(*whole[0]));
            CHECK(sums.primitives == all.primitives);
            CHECK(sums.primitives - sums.culled == emitted);
            CHECK(emitted > 100);
            // Of a closed surface about half looks away.
            CHECK((sums.culled > sums.primitives / 3) == cull_back);
        }
    }

    TEST_CASE("a triangle in several regions is drawn once") {
        schema::DrawFrameT draw = draw_frame(9, 1);
        draw.counts = true;
        const auto gps = run_machine({1, 1, plenty_bytes, Recording::flight}, draw);
        std::set<std::tuple<std::uint32_t, int, int, int>> drawn;  // Slab, cell and triangle.
        std::size_t emitted = 0;
        for (const auto* region : *gps[0]->box.of<schema::RegionPrograms>()[0]->regions()) {
            for (const auto* s : *region->segments()) {
                const std::uint32_t words = isa::triangle::word_count;
                for (std::uint32_t i = 0; i < s->word_count() / words; ++i) {
                    const auto* o = region->origins()->Get(s->first_word() / words + i);
                    drawn.emplace(s->slab(), o->i(), o->j(), o->triangle());
                    ++emitted;
                }
            }
        }
        const Sums sums = sums_of(counts_of(*gps[0]));
        CHECK(sums.primitives - sums.culled == drawn.size());
        CHECK(emitted > drawn.size());
    }

    TEST_CASE("each view counts, and what lies behind the viewer is culled") {
        const auto once = run_machine({1, 1}, counted_frame());
        schema::DrawFrameT draw = counted_frame();
        auto behind = std::make_unique<schema::ViewT>(*draw.views[0]);
        behind->voxel_to_eye = std::make_unique<schema::Matrix>(
            to_wire(glm::translate(glm::dmat4(1.0), glm::dvec3(-9.5, -9.5, 50))));
        draw.views.push_back(std::move(behind));
        draw.region_costs.clear();
        const auto twice = run_machine({1, 1}, draw);
        const Sums one = sums_of(counts_of(*once[0])), two = sums_of(counts_of(*twice[0]));
        CHECK(two.primitives == 2 * one.primitives);
        CHECK(two.culled == one.culled + one.primitives);
        CHECK(counts_of(*twice[0]).words() == counts_of(*once[0]).words());
    }
}
