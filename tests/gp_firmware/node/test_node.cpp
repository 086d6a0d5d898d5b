// The GP as a node: volumes, surfaces, meshes, and what it refuses.
#include <doctest/doctest.h>

#include "tests/gp_firmware/node/support.hpp"

using namespace pxpl5;
using namespace pxpl5::test;

TEST_SUITE("gp/node") {
    TEST_CASE("a volume is acknowledged when its last slice is in") {
        LoneGp gp({3, 1}, 1);
        load(gp);
        const auto ready = gp.box.of<schema::VolumeReady>();
        REQUIRE(ready.size() == 1);
        CHECK(ready[0]->volume() == 1);
        CHECK(ready[0]->slabs() == 6);  // 1, 4, 7, 10, 13, 16 of 0..18.
        CHECK(ready[0]->memory_bytes() > 0);
        CHECK(gp.box.sent[0].to == bus::host_id);
    }

    TEST_CASE("the sphere's area and volume come out of the slabs of all GPs") {
        double area = 0, enclosed = 0;
        std::uint32_t slabs = 0;
        for (int i = 0; i < 3; ++i) {
            LoneGp gp({3, 1}, i);
            load(gp);
            gp.receive(set_surface(4, 7, 100));
            CHECK(gp.work() >= 6);  // A slab to the piece.
            const auto built = gp.box.of<schema::SurfaceBuilt>();
            REQUIRE(built.size() == 1);
            CHECK(built[0]->surface() == 4);
            CHECK(built[0]->revision() == 7);
            for (const auto* s : *built[0]->slabs()) {
                CHECK(static_cast<int>(s->slab()) % 3 == i);
                area += s->area_mm2();
                enclosed += s->volume_mm3();
                ++slabs;
            }
        }
        CHECK(slabs == n - 1);
        CHECK(area == doctest::Approx(4 * 3.14159 * 49).epsilon(0.02));
        CHECK(enclosed == doctest::Approx(4.0 / 3 * 3.14159 * 343).epsilon(0.02));
    }

    TEST_CASE("a newer revision takes the place of work that waits or is half done") {
        LoneGp gp({1, 1}, 0);
        load(gp);
        gp.receive(set_surface(4, 1, 100));
        gp.receive(set_surface(5, 1, 100));
        gp.node.work(gp.box);
        gp.node.work(gp.box);  // Two slabs of revision 1 of surface 4.
        gp.receive(set_surface(4, 2, 110));
        gp.receive(set_surface(4, 3, 120));
        gp.work();
        const auto built = gp.box.of<schema::SurfaceBuilt>();
        REQUIRE(built.size() == 2);
        CHECK(built[0]->surface() == 5);
        CHECK(built[1]->surface() == 4);
        CHECK(built[1]->revision() == 3);
    }

    TEST_CASE("a surface that is extracted again equals one extracted at once") {
        LoneGp twice({1, 1}, 0), once({1, 1}, 0);
        load(twice);
        load(once);
        twice.receive(set_surface(4, 1, 60));
        twice.work();
        twice.receive(set_surface(4, 2, 100));
        once.receive(set_surface(4, 2, 100));
        schema::FetchMeshT fetch;
        fetch.surface = 4;
        for (LoneGp* gp : {&twice, &once}) {
            gp->receive(bus::pack(fetch));
            gp->work();
            REQUIRE(gp->box.of<schema::MeshPart>().size() == 1);
        }
        const auto a = twice.box.sent.back().payload.bytes();
        const auto b = once.box.sent.back().payload.bytes();
        CHECK(std::ranges::equal(a, b));
    }

    TEST_CASE("a fetched mesh lies on the sphere, its normals point outwards") {
        LoneGp gp({1, 1}, 0);
        load(gp);
        gp.receive(set_surface(4, 1, 100));
        schema::FetchMeshT fetch;
        fetch.surface = 4;
        gp.receive(bus::pack(fetch));
        gp.work();
        const auto parts = gp.box.of<schema::MeshPart>();
        REQUIRE(parts.size() == 1);
        CHECK(parts[0]->revision() == 1);
        CHECK(parts[0]->slabs()->size() == n - 1);
        int vertices = 0;
        for (const auto* slab : *parts[0]->slabs()) {
            CHECK(slab->keys()->size() == slab->vertices()->size());
            for (const auto* v : *slab->vertices()) {
                const glm::dvec3 p(v->x() - 9.5, v->y() - 9.5, v->z() - 9.5);
                const glm::dvec3 normal(v->nx(), v->ny(), v->nz());
                CHECK(glm::length(p) == doctest::Approx(7).epsilon(0.03));
                CHECK(glm::dot(normal, p) / 7 == doctest::Approx(1).epsilon(0.05));
                ++vertices;
            }
        }
        CHECK(vertices > 500);
    }

    TEST_CASE("a removed surface is gone, and its memory free") {
        LoneGp gp({1, 1}, 0);
        load(gp);
        const auto empty_bytes = gp.box.of<schema::VolumeReady>()[0]->memory_bytes();
        gp.receive(set_surface(4, 1, 100));
        schema::RemoveSurfaceT remove;
        remove.surface = 4;
        gp.receive(bus::pack(remove));
        gp.receive(set_surface(5, 1, 250));  // No voxel is as high: empty.
        gp.work();
        const auto built = gp.box.of<schema::SurfaceBuilt>();
        REQUIRE(built.size() == 2);
        CHECK(built[0]->memory_bytes() > empty_bytes);
        CHECK(built[1]->memory_bytes() == empty_bytes);
        gp.receive(bus::pack(draw_frame(1, 1)));
        CHECK(gp.fault_of_work().find("surface 4, which is not held") != std::string::npos);
    }

    TEST_CASE("a new volume drops volume, surfaces and work, but no frame is left waiting for") {
        LoneGp gp({1, 1}, 0);
        load(gp);
        gp.receive(set_surface(4, 1, 100));
        gp.receive(bus::pack(draw_frame(1, 1)));
        gp.node.work(gp.box);
        load(gp, 2);
        CHECK(gp.box.of<schema::SurfaceBuilt>().empty());
        REQUIRE(gp.box.of<schema::RegionPrograms>().size() == 1);
        CHECK(gp.box.of<schema::RegionPrograms>()[0]->regions()->size() == 0);
        const auto ready = gp.box.of<schema::VolumeReady>();
        REQUIRE(ready.size() == 2);
        CHECK(ready[1]->volume() == 2);
        CHECK(ready[1]->memory_bytes() == ready[0]->memory_bytes());
    }

    TEST_CASE("slices of another volume, in the wrong order or missing, are faults that name it") {
        LoneGp gp({1, 1}, 0);
        CHECK(gp.fault_of(slices(0, 1, 8)).find("volume 8 arrived, but no volume") !=
              std::string::npos);
        gp.receive(header());
        CHECK(gp.fault_of(slices(0, 1, 8)).find("volume 8 arrived, but volume 1") !=
              std::string::npos);
        gp.receive(slices(3, 1));
        CHECK(gp.fault_of_work() == "slice 3 arrived, but slice 0 is next");
        CHECK(gp.cause.request == bus::Body::Slices);
        gp.receive(slices(0, 5));
        schema::VolumeEndT end;
        end.volume = 1;
        gp.receive(bus::pack(end));
        CHECK(gp.fault_of_work() == "volume 1 ended, but slices are missing");
        CHECK(gp.cause.request == bus::Body::VolumeEnd);
        gp.receive(set_surface(4, 1, 100));
        CHECK(gp.fault_of_work().find("before all slices of volume 1") != std::string::npos);
        CHECK(gp.cause.request == bus::Body::SetSurface);
        CHECK_FALSE(gp.cause.frame.has_value());
    }

    TEST_CASE("a volume beyond the memory is refused with the number of GPs that would do") {
        LoneGp gp({1, 1, 20000}, 0);
        const std::string fault = gp.fault_of(header());
        CHECK(gp.code == schema::FaultCode::out_of_memory);
        CHECK(fault.find("GPs with 20000 bytes each would do") != std::string::npos);
        gp.receive(slices(0, n));  // Told once is enough.
        CHECK_FALSE(gp.node.work(gp.box));
        CHECK(gp.fault_of(set_surface(4, 1, 100)).find("no volume is stored") != std::string::npos);
    }

    TEST_CASE("messages that a GP cannot obey are faults that say why") {
        LoneGp master({2, 1}, 0), other({2, 1}, 1);
        CHECK(other.fault_of(bus::pack(draw_frame(1, 1))) ==
              "DrawFrame came to GP 1; GP 0 is the Master");
        CHECK(master.fault_of(bus::pack(schema::CreditT{})) == "a GP does not accept Credit");
        load(master);
        schema::DrawFrameT draw = draw_frame(1, 1);
        draw.views[0]->voxel_to_eye = std::make_unique<schema::Matrix>(to_wire(glm::dmat4(3.0)));
        CHECK(master.fault_of(bus::pack(draw)).find("no rigid motion") != std::string::npos);
        CHECK(master.box.of<schema::BeginFrame>().empty());
        schema::FetchMeshT fetch;
        fetch.surface = 8;
        master.receive(bus::pack(fetch));
        CHECK(master.fault_of_work() == "the mesh of surface 8 was requested, but is not stored");

        schema::BeginFrameT begin;
        begin.draw = std::make_unique<schema::DrawFrameT>(draw_frame(1, 1));
        begin.assignment = {0, 0, 0, 1, 0, 0};
        CHECK(other.fault_of(bus::pack(begin)) == "frame 1 assigns a region to Renderer 1 of 1");
        gp::GpNode unborn;
        Mailbox box;
        CHECK_THROWS_WITH_AS(unborn.receive(message(header(), 0, 1), box),
                             "VolumeHeader came before Topology", bus::NodeFault);
        CHECK_THROWS_WITH_AS(unborn.receive(message(topology({}), 0, 77), box),
                             "node 77 is not one of the 1 GPs in the topology", bus::NodeFault);
    }
}
