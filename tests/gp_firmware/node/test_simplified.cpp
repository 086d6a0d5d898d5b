// The GP as a node: simplified surfaces in meshes and frames.
#include <doctest/doctest.h>

#include <set>

#include "tests/gp_firmware/node/support.hpp"

using namespace pxpl5;
using namespace pxpl5::test;

namespace {

bus::Payload fetch(int detail) {
    schema::FetchMeshT f;
    f.surface = 4;
    f.detail = static_cast<std::uint8_t>(detail);
    return bus::pack(f);
}

const schema::MeshPart& fetched(LoneGp& gp, int detail) {
    gp.receive(fetch(detail));
    gp.work();
    REQUIRE(!gp.box.of<schema::MeshPart>().empty());
    return *gp.box.of<schema::MeshPart>().back();
}

std::size_t triangles_of(const schema::MeshPart& part) {
    std::size_t triangles = 0;
    for (const auto* mesh : *part.slabs()) {
        triangles += mesh->indices()->size() / 3;
    }
    return triangles;
}

schema::DrawFrameT frame(std::uint32_t number, std::uint32_t revision, int detail) {
    schema::DrawFrameT draw = draw_frame(number, revision);
    draw.surfaces[0].mutate_detail(static_cast<std::uint8_t>(detail));
    return draw;
}

/// A mask of surface 4 that hides all triangles of the exact mesh.
bus::Payload mask_of_all(const schema::MeshPart& exact) {
    schema::MaskSurfaceT mask;
    mask.surface = 4;
    mask.revision = 1;
    for (const auto* slab : *exact.slabs()) {
        auto wire = std::make_unique<schema::SlabMaskT>();
        wire->slab = slab->slab();
        wire->hidden.assign((slab->indices()->size() / 3 + 7) / 8, 0xFF);
        mask.slabs.push_back(std::move(wire));
    }
    return bus::pack(mask);
}

/// A GP with the sphere's surface.
std::unique_ptr<LoneGp> gp_with_surface(MachineSize size = {}, double isovalue = 100) {
    auto gp = std::make_unique<LoneGp>(size, 0);
    load(*gp, 1, size.slabs_per_set);
    gp->receive(set_surface(4, 1, isovalue));
    gp->work();
    return gp;
}

}  // namespace

TEST_SUITE("gp/node_simplified") {
    TEST_CASE("a simplified mesh has one part per block, fewer triangles and a bound") {
        const auto gp = gp_with_surface();
        const std::size_t exact = triangles_of(fetched(*gp, 0));
        std::size_t before = exact;
        double bound_mm = 0;
        for (const int detail : {1, 2, 3}) {
            const schema::MeshPart& part = fetched(*gp, detail);
            CAPTURE(detail);
            CHECK(part.detail() == detail);
            REQUIRE(part.slabs()->size() == 2);  // 19 slabs: 16 and 3.
            CHECK(part.slabs()->Get(0)->slab() == 0);
            CHECK(part.slabs()->Get(1)->slab() == 16);
            CHECK(triangles_of(part) > 0);
            CHECK(triangles_of(part) < before);
            CHECK(part.moved_mm() > bound_mm);
            before = triangles_of(part);
            bound_mm = part.moved_mm();
        }
        const schema::MeshPart& again = fetched(*gp, 0);
        CHECK(triangles_of(again) == exact);
        CHECK(again.moved_mm() == 0);
    }

    TEST_CASE("a simplified mesh is kept, charged to the memory, and dropped with its revision") {
        LoneGp gp({}, 0);
        load(gp);
        const std::uint64_t without = gp.node.status().memory_bytes;
        gp.receive(set_surface(4, 1, 100));
        gp.work();
        const std::uint64_t exact = gp.node.status().memory_bytes;
        gp.receive(fetch(1));
        CHECK(gp.work() >= 3);  // Two blocks are two pieces.
        const std::uint64_t with = gp.node.status().memory_bytes;
        CHECK(with > exact);
        gp.receive(fetch(1));
        gp.work();
        CHECK(gp.node.status().memory_bytes == with);

        gp.receive(set_surface(4, 2, 130));
        gp.work();
        const std::size_t smaller = triangles_of(fetched(gp, 1));
        const auto fresh = gp_with_surface({}, 130);
        CHECK(smaller == triangles_of(fetched(*fresh, 1)));
        schema::RemoveSurfaceT remove;
        remove.surface = 4;
        gp.receive(bus::pack(remove));
        gp.work();
        CHECK(gp.node.status().memory_bytes == without);
    }

    TEST_CASE("a frame draws the simplified mesh and states its bound, whatever the machine") {
        const auto exact = streams(run_machine({1, 2}, frame(1, 1, 0)));
        const auto one = run_machine({1, 2}, frame(1, 1, 2));
        const auto several = run_machine({2, 3, plenty_bytes, Recording::off, 16}, frame(1, 1, 2));
        CHECK(streams(one) == streams(several));
        CHECK(streams(one) != exact);
        std::set<std::uint32_t> slabs;
        for (const auto& [place, words] : streams(one)) {
            slabs.insert(place.second);
        }
        CHECK(slabs == std::set<std::uint32_t>{0, 16});
        const auto bound_of = [](const auto& gps) {
            double most_mm = 0;
            for (const auto& gp : gps) {
                for (const auto* programs : gp->box.template of<schema::RegionPrograms>()) {
                    most_mm = std::max(most_mm, programs->moved_mm());
                }
            }
            return most_mm;
        };
        CHECK(bound_of(one) > 0);
        CHECK(bound_of(one) == bound_of(several));
        CHECK(bound_of(run_machine({1, 2}, frame(1, 1, 0))) == 0);
    }

    TEST_CASE("masks and the choice of slabs hold for simplified surfaces") {
        const auto gp = gp_with_surface();
        const std::size_t whole = triangles_of(fetched(*gp, 1));
        gp->receive(mask_of_all(fetched(*gp, 0)));
        gp->work();
        CHECK(triangles_of(fetched(*gp, 1)) == 0);
        gp->receive(set_surface(4, 2, 100));
        gp->work();
        CHECK(triangles_of(fetched(*gp, 1)) == whole);

        schema::DrawFrameT draw = frame(1, 2, 1);
        draw.surfaces[0].mutate_slabs(SlabChoice::in_gaps);  // The volume has no gap.
        gp->receive(bus::pack(draw));
        gp->work();
        const auto* programs = gp->box.of<schema::RegionPrograms>().back();
        CHECK(programs->triangles_in() == 0);
        draw.frame = 2;
        draw.surfaces[0].mutate_slabs(SlabChoice::outside_gaps);
        gp->receive(bus::pack(draw));
        gp->work();
        CHECK(gp->box.of<schema::RegionPrograms>().back()->triangles_in() == whole);
    }

    TEST_CASE("a recorded simplified triangle has no cell") {
        const auto gps = run_machine({1, 1, plenty_bytes, Recording::full}, frame(1, 1, 2));
        std::size_t primitives = 0;
        for (const auto* programs : gps[0]->box.of<schema::RegionPrograms>()) {
            for (const auto* region : *programs->regions()) {
                REQUIRE(region->origins() != nullptr);
                for (const auto* origin : *region->origins()) {
                    CHECK(origin->inside() == 0);
                    ++primitives;
                }
            }
        }
        CHECK(primitives > 20);
    }

    TEST_CASE("blocks that are spread over GPs are refused, and the Renderers are answered") {
        const std::string remedy = "load the volume with gp.slabs_per_set=16 or a multiple";
        const auto gp = gp_with_surface({2, 3, plenty_bytes, Recording::off, 8});
        gp->receive(fetch(1));
        const std::string refused = gp->fault_of_work();
        CHECK(refused.find("have 8 slabs each on 2 GPs") != std::string::npos);
        CHECK(refused.find(remedy) != std::string::npos);
        gp->receive(bus::pack(frame(1, 1, 1)));
        CHECK(gp->fault_of_work().find(remedy) != std::string::npos);
        CHECK(gp->box.of<schema::RegionPrograms>().size() == 3);
    }
}
