// The GP as a node: surfaces that do not fit into its memory give the same bits as those that do.
#include <doctest/doctest.h>

#include "tests/gp_firmware/node/support.hpp"

using namespace pxpl5;
using namespace pxpl5::test;

namespace {

bus::Payload fetch(bool origins, int detail) {
    schema::FetchMeshT f;
    f.surface = 4;
    f.origins = origins;
    f.detail = static_cast<std::uint8_t>(detail);
    return bus::pack(f);
}

/// A GP's memory that has room for the volume, while it loads too, and for a part of the surface,
/// whose meshes have no spare capacity.
std::uint64_t scarce_bytes(double part) {
    LoneGp gp({}, 0);
    load(gp);
    const std::uint64_t volume = gp.node.status().memory_bytes;
    gp.receive(set_surface(4, 1, 100));
    gp.receive(fetch(false, 0));
    gp.work();
    std::size_t surface = 0;
    for (const schema::SlabMesh* slab : *gp.box.of<schema::MeshPart>().back()->slabs()) {
        surface += slab->vertices()->size() * (sizeof(gp::Vertex) + sizeof(std::uint64_t)) +
                   slab->indices()->size() * sizeof(std::uint32_t);
    }
    return std::max(gp::peak_bytes(shape(), {}),
                    volume + static_cast<std::uint64_t>(part * static_cast<double>(surface)));
}

std::unique_ptr<LoneGp> gp_with_surface(MachineSize size) {
    auto gp = std::make_unique<LoneGp>(size, 0);
    load(*gp, 1, size.slabs_per_set);
    gp->receive(set_surface(4, 1, 100));
    gp->work();
    return gp;
}

const schema::SurfaceBuilt& last_built(const LoneGp& gp) {
    REQUIRE(!gp.box.of<schema::SurfaceBuilt>().empty());
    return *gp.box.of<schema::SurfaceBuilt>().back();
}

/// The bytes of all messages of a kind.
template <typename T>
std::vector<std::vector<std::uint8_t>> bytes_of(const LoneGp& gp) {
    std::vector<std::vector<std::uint8_t>> all;
    for (const Sent& sent : gp.box.sent) {
        if (sent.as<T>() != nullptr) {
            all.emplace_back(sent.payload.bytes().begin(), sent.payload.bytes().end());
        }
    }
    REQUIRE(!all.empty());
    return all;
}

/// Hides every other triangle.
bus::Payload mask_of(const LoneGp& gp) {
    schema::MaskSurfaceT mask;
    mask.surface = 4;
    mask.revision = 1;
    for (const schema::SlabCounts* slab : *last_built(gp).slabs()) {
        auto wire = std::make_unique<schema::SlabMaskT>();
        wire->slab = slab->slab();
        wire->hidden.assign((slab->triangles() + 7) / 8, 0x55);
        mask.slabs.push_back(std::move(wire));
    }
    return bus::pack(mask);
}

schema::DrawFrameT frame_of_both_eyes(std::uint32_t number) {
    schema::DrawFrameT draw = draw_frame(number, 1);
    auto other = std::make_unique<schema::ViewT>();
    other->voxel_to_eye = std::make_unique<schema::Matrix>(
        to_wire(glm::translate(glm::dmat4(1.0), glm::dvec3(-8.5, -9.5, -50))));
    other->projection = std::make_unique<schema::Matrix>(*draw.views[0]->projection);
    draw.views.push_back(std::move(other));
    return draw;
}

}  // namespace

TEST_SUITE("gp/node_left_out") {
    TEST_CASE("slabs that do not fit are left out, counted, and named with a remedy") {
        const auto whole = gp_with_surface({});
        CHECK(last_built(*whole).left_out() == 0);
        CHECK(last_built(*whole).gps_to_hold_all() == 0);
        const std::uint64_t memory = scarce_bytes(0.4);
        const auto gp = gp_with_surface({1, 1, memory});
        const schema::SurfaceBuilt& built = last_built(*gp);
        CHECK(built.left_out() > 0);
        CHECK(built.left_out() < n - 1);
        CHECK(built.memory_bytes() <= memory);
        REQUIRE(built.slabs()->size() == n - 1);
        for (unsigned i = 0; i < n - 1; ++i) {
            CHECK(built.slabs()->Get(i)->triangles() ==
                  last_built(*whole).slabs()->Get(i)->triangles());
            CHECK(built.slabs()->Get(i)->area_mm2() ==
                  last_built(*whole).slabs()->Get(i)->area_mm2());
        }
        // An estimate: the middle slabs of a ball have more triangles than the others.
        const auto gps = static_cast<int>(built.gps_to_hold_all());
        CHECK(gps > 1);
        std::uint32_t left_out = 0;
        for (const auto& each : run_machine({gps, 1, memory}, draw_frame(1, 1))) {
            left_out += last_built(*each).left_out();
        }
        CHECK(left_out <= built.left_out() / 4);
        for (const auto& each : run_machine({gps + 2, 1, memory}, draw_frame(1, 1))) {
            CHECK(last_built(*each).left_out() == 0);
        }
    }

    TEST_CASE("frames have the same streams and origins, however much is left out") {
        for (const Recording recording : {Recording::off, Recording::flight}) {
            const auto whole = run_machine({1, 3, plenty_bytes, recording}, frame_of_both_eyes(9));
            for (const double part : {0.0, 0.3, 0.8}) {
                CAPTURE(part);
                const auto scarce =
                    run_machine({1, 3, scarce_bytes(part), recording}, frame_of_both_eyes(9));
                CHECK(last_built(*scarce[0]).left_out() > 0);
                CHECK(streams(scarce) == streams(whole));
                CHECK(bytes_of<schema::RegionPrograms>(*scarce[0]) ==
                      bytes_of<schema::RegionPrograms>(*whole[0]));
            }
        }
    }

    TEST_CASE("meshes have the same bytes, with and without origins, recorded or not") {
        for (const Recording recording : {Recording::off, Recording::full}) {
            const auto whole = gp_with_surface({1, 1, plenty_bytes, recording});
            const auto scarce = gp_with_surface({1, 1, scarce_bytes(0.3), recording});
            for (const bool origins : {false, true}) {
                CAPTURE(origins);
                whole->receive(fetch(origins, 0));
                whole->work();
                scarce->receive(fetch(origins, 0));
                scarce->work();
                CHECK(bytes_of<schema::MeshPart>(*scarce) == bytes_of<schema::MeshPart>(*whole));
            }
        }
    }

    TEST_CASE("a mask hides triangles of slabs that are left out") {
        const auto whole = gp_with_surface({});
        const auto scarce = gp_with_surface({1, 1, scarce_bytes(0.3)});
        for (LoneGp* gp : {whole.get(), scarce.get()}) {
            gp->receive(bus::pack(draw_frame(1, 1)));
            gp->receive(mask_of(*gp));
            gp->receive(bus::pack(draw_frame(2, 1)));
            gp->work();
        }
        const auto programs = scarce->box.of<schema::RegionPrograms>();
        CHECK(programs[1]->triangles_out() < programs[0]->triangles_out());
        CHECK(bytes_of<schema::RegionPrograms>(*scarce) ==
              bytes_of<schema::RegionPrograms>(*whole));
    }

    TEST_CASE("simplified surfaces are the same, and take the room of exact slabs") {
        const auto whole = gp_with_surface({});
        whole->receive(fetch(false, 1));
        whole->receive(fetch(false, 0));
        whole->work();
        for (const double part : {0.4, 0.97, 1.0}) {
            CAPTURE(part);
            const std::uint64_t memory = scarce_bytes(part);
            const auto gp = gp_with_surface({1, 1, memory});
            gp->receive(fetch(false, 1));
            gp->receive(fetch(false, 0));
            gp->work();
            CHECK(bytes_of<schema::MeshPart>(*gp) == bytes_of<schema::MeshPart>(*whole));
            CHECK(gp->node.status().memory_bytes <= memory);
            // An extraction takes the room of simplified surfaces.
            gp->receive(set_surface(5, 1, 100));
            gp->receive(set_surface(4, 2, 100));
            gp->work();
            CHECK(last_built(*gp).memory_bytes() <= memory);
        }
    }

    TEST_CASE("a simplified surface that does not fit by itself is a fault, and leaves nothing") {
        const auto gp = gp_with_surface({1, 1, scarce_bytes(0)});
        const std::uint64_t used = gp->node.status().memory_bytes;
        gp->receive(fetch(false, 1));
        const std::string refused = gp->fault_of_work();
        CHECK(refused.find("surface 4, simplified: needs") != std::string::npos);
        CHECK(refused.find("draw the surface exactly") != std::string::npos);
        CHECK(gp->code == schema::FaultCode::out_of_memory);
        CHECK(gp->node.status().memory_bytes == used);  // No exact slab went in vain.
        const auto whole = gp_with_surface({});
        for (LoneGp* each : {gp.get(), whole.get()}) {
            each->receive(fetch(false, 0));
            each->work();
        }
        CHECK(bytes_of<schema::MeshPart>(*gp) == bytes_of<schema::MeshPart>(*whole));
    }

    TEST_CASE("the node reads messages after each slab that it extracts again") {
        const auto gp = gp_with_surface({1, 1, scarce_bytes(0.3)});
        gp->receive(bus::pack(draw_frame(1, 1)));
        CHECK(gp->work() > static_cast<int>(last_built(*gp).left_out()));
    }

    TEST_CASE("nothing is left out where the surface fits without spare capacity") {
        const std::uint64_t memory = scarce_bytes(1);
        const auto gp = gp_with_surface({1, 1, memory});
        CHECK(last_built(*gp).left_out() == 0);
        CHECK(last_built(*gp).memory_bytes() == memory);
        CHECK(last_built(*gp_with_surface({1, 1, memory - 1})).left_out() == 1);

        // A larger ball takes the room of the one before, whose last slabs are still there.
        for (const double isovalue : {130.0, 100.0}) {
            gp->receive(set_surface(4, static_cast<std::uint32_t>(isovalue), isovalue));
            gp->work();
            CHECK(last_built(*gp).left_out() == 0);
        }
    }

    TEST_CASE("slabs that were left out come back when another surface goes") {
        LoneGp gp({1, 1, scarce_bytes(1.5)}, 0);
        load(gp);
        gp.receive(set_surface(5, 1, 100));
        gp.receive(set_surface(4, 1, 100));
        gp.work();
        CHECK(last_built(gp).left_out() > 1);
        schema::RemoveSurfaceT remove;
        remove.surface = 5;
        gp.receive(bus::pack(remove));
        gp.receive(bus::pack(draw_frame(1, 1)));
        gp.work();
        const std::uint64_t drawn = gp.node.status().memory_bytes;  // The frame stored the slabs.
        CHECK(gp.box.of<schema::RegionPrograms>().size() == 1);
        gp.receive(bus::pack(draw_frame(2, 1)));
        CHECK(gp.work() < 5);
        CHECK(gp.node.status().memory_bytes == drawn);
        CHECK(drawn > last_built(gp).memory_bytes() / 2);
        gp.receive(set_surface(4, 2, 100));
        gp.work();
        CHECK(last_built(gp).left_out() == 0);
    }

    TEST_CASE("a later revision has its slabs in memory again, if they fit") {
        const auto gp = gp_with_surface({1, 1, scarce_bytes(0.5)});
        CHECK(last_built(*gp).left_out() > 0);
        gp->receive(set_surface(4, 2, 160));  // A small ball.
        gp->work();
        CHECK(last_built(*gp).revision() == 2);
        CHECK(last_built(*gp).left_out() == 0);
        gp->receive(set_surface(4, 3, 100));
        gp->work();
        CHECK(last_built(*gp).left_out() > 0);
        schema::RemoveSurfaceT remove;
        remove.surface = 4;
        gp->receive(bus::pack(remove));
        gp->work();
        LoneGp empty({}, 0);
        load(empty);
        CHECK(gp->node.status().memory_bytes == empty.node.status().memory_bytes);
    }
}
