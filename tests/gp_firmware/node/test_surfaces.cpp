// The GP as a node: origins, masks, measuring, and who goes first.
#include <doctest/doctest.h>

#include <fmt/format.h>

#include <functional>
#include <set>

#include "isa/contract/triangle_shape.hpp"
#include "tests/gp_firmware/node/support.hpp"

using namespace pxpl5;
using namespace pxpl5::test;

namespace {

bus::Payload fetch(bool origins) {
    schema::FetchMeshT f;
    f.surface = 4;
    f.origins = origins;
    return bus::pack(f);
}

bus::Payload drop(std::uint32_t volume) {
    schema::DropVolumeT d;
    d.volume = volume;
    return bus::pack(d);
}

bus::Payload measure(const std::vector<double>& isovalues) {
    schema::MeasureIsovaluesT m;
    m.isovalues = isovalues;
    return bus::pack(m);
}

/// Returns a mask of surface 4 that hides (slab, triangle) if `hide` returns true.
template <class Hide>
schema::MaskSurfaceT mask(const schema::MeshPart& part, std::uint32_t revision, Hide hide) {
    schema::MaskSurfaceT m;
    m.surface = 4;
    m.revision = revision;
    for (const auto* slab : *part.slabs()) {
        auto wire = std::make_unique<schema::SlabMaskT>();
        wire->slab = slab->slab();
        const std::size_t triangles = slab->indices()->size() / 3;
        wire->hidden.resize((triangles + 7) / 8);
        for (std::size_t t = 0; t < triangles; ++t) {
            if (hide(slab->slab(), t)) {
                wire->hidden[t / 8] |= static_cast<std::uint8_t>(1U << t % 8);
            }
        }
        m.slabs.push_back(std::move(wire));
    }
    return m;
}

using Primitives = std::multiset<std::vector<std::uint32_t>>;

/// Draws surface 4 at `revision`: the words of every primitive, with region and slab.
Primitives drawn(LoneGp& gp, std::uint32_t revision) {
    gp.box.sent.clear();
    gp.receive(bus::pack(draw_frame(1, revision)));
    gp.work();
    Primitives primitives;
    for (const auto* programs : gp.box.of<schema::RegionPrograms>()) {
        for (const auto* region : *programs->regions()) {
            for (const auto* s : *region->segments()) {
                for (std::uint32_t w = 0; w < s->word_count(); w += isa::triangle::word_count) {
                    std::vector<std::uint32_t> words = {region->region(), s->slab()};
                    const auto first = region->words()->begin() + s->first_word() + w;
                    words.insert(words.end(), first, first + isa::triangle::word_count);
                    primitives.insert(std::move(words));
                }
            }
        }
    }
    return primitives;
}

const schema::MeshPart& fetched(LoneGp& gp, bool origins) {
    gp.receive(fetch(origins));
    gp.work();
    REQUIRE(gp.box.of<schema::MeshPart>().size() >= 1);
    return *gp.box.of<schema::MeshPart>().back();
}

}  // namespace

TEST_SUITE("gp/node_surfaces") {
    TEST_CASE("origins of a mesh are the same whether they are kept or extracted again") {
        LoneGp keeping({2, 1, plenty_bytes, Recording::full}, 1), plain({2, 1}, 1);
        for (LoneGp* gp : {&keeping, &plain}) {
            load(*gp);
            gp->receive(set_surface(4, 1, 60));
            gp->receive(set_surface(4, 2, 100));
            CHECK(fetched(*gp, false).slabs()->Get(3)->origins() == nullptr);
            fetched(*gp, true);
        }
        const auto a = keeping.box.sent.back().payload.bytes();
        const auto b = plain.box.sent.back().payload.bytes();
        CHECK(std::ranges::equal(a, b));
        std::size_t triangles = 0;
        for (const auto* slab : *plain.box.of<schema::MeshPart>().back()->slabs()) {
            REQUIRE(slab->origins() != nullptr);
            CHECK(slab->origins()->size() == slab->indices()->size() / 3);
            triangles += slab->origins()->size();
            for (std::uint32_t t = 0; t < slab->origins()->size(); ++t) {
                // The triangle lies in the cell that its origin names.
                const auto* origin = slab->origins()->Get(t);
                for (std::uint32_t c = 0; c < 3; ++c) {
                    const auto* v = slab->vertices()->Get(slab->indices()->Get(3 * t + c));
                    CHECK(std::abs(v->x() - origin->i() - 0.5) <= 0.5);
                    CHECK(std::abs(v->y() - origin->j() - 0.5) <= 0.5);
                    CHECK(std::abs(v->z() - static_cast<double>(slab->slab()) - 0.5) <= 0.5);
                }
            }
        }
        CHECK(triangles > 500);
    }

    TEST_CASE("a mesh is handed over slab by slab, so that newer wishes are heard in between") {
        LoneGp gp({1, 1}, 0);
        load(gp);
        gp.receive(set_surface(4, 1, 100));
        gp.work();
        gp.receive(fetch(true));
        CHECK(gp.work() == 1 + (n - 1) + 1);  // Begin, the slabs, the end.
    }

    TEST_CASE("half a surface is not fetched") {
        LoneGp gp({1, 1}, 0);
        load(gp);
        gp.receive(set_surface(4, 1, 100));
        gp.node.work(gp.box);
        gp.receive(fetch(false));
        gp.receive(set_surface(4, 2, 100));
        CHECK(gp.fault_of_work() ==
              "the mesh of surface 4 was requested, but is not completely stored");
    }

    TEST_CASE("a mask hides its triangles, and those alone") {
        LoneGp gp({1, 1}, 0);
        load(gp);
        gp.receive(set_surface(4, 3, 100));
        gp.work();
        const Primitives all = drawn(gp, 3);
        const std::vector<std::uint8_t> part = [&] {
            fetched(gp, false);
            const auto bytes = gp.box.sent.back().payload.bytes();
            return std::vector<std::uint8_t>(bytes.begin(), bytes.end());
        }();
        const schema::MeshPart& mesh = *schema::GetMessage(part.data())->body_as_MeshPart();
        const auto odd = [](std::uint32_t slab, std::size_t t) { return (slab + t) % 3 == 1; };
        gp.receive(bus::pack(mask(mesh, 3, odd)));
        const Primitives without_odd = drawn(gp, 3);
        gp.receive(bus::pack(mask(mesh, 3, std::not_fn(odd))));
        const Primitives only_odd = drawn(gp, 3);
        CHECK(all.size() > 500);
        CHECK(!only_odd.empty());
        CHECK(!without_odd.empty());
        Primitives both = without_odd;
        both.insert(only_odd.begin(), only_odd.end());
        CHECK(both == all);

        // One of another revision is passed over; one that names no slab hides nothing.
        gp.receive(bus::pack(mask(mesh, 2, odd)));
        CHECK(drawn(gp, 3) == only_odd);
        schema::MaskSurfaceT none;
        none.surface = 4;
        none.revision = 3;
        gp.receive(bus::pack(none));
        CHECK(drawn(gp, 3) == all);
        // And it ends with the revision.
        gp.receive(bus::pack(mask(mesh, 3, odd)));
        gp.receive(set_surface(4, 4, 100));
        CHECK(drawn(gp, 4) == all);
    }

    TEST_CASE("a mask of a wrong size is refused with both sizes, and changes nothing") {
        LoneGp gp({2, 1}, 1);
        load(gp);
        gp.receive(set_surface(4, 1, 100));
        const schema::MeshPart& part = fetched(gp, false);
        const std::size_t triangles = part.slabs()->Get(4)->indices()->size() / 3;
        schema::MaskSurfaceT wrong = mask(part, 1, [](std::uint32_t, std::size_t) { return true; });
        wrong.slabs[4]->hidden.push_back(0);
        wrong.slabs[3]->slab = 6;  // The other GP's: of whatever size.
        CHECK(wrong.slabs[4]->slab == 9);
        gp.receive(bus::pack(wrong));
        CHECK(gp.fault_of_work() ==
              fmt::format("the mask of surface 4, slab 9, has {} bytes, but its "
                          "{} triangles need {}",
                          (triangles + 7) / 8 + 1, triangles, (triangles + 7) / 8));
        schema::BeginFrameT begin;
        begin.draw = std::make_unique<schema::DrawFrameT>(draw_frame(1, 1));
        begin.assignment = {0, 0, 0, 0, 0, 0};
        gp.box.sent.clear();
        gp.receive(bus::pack(begin), first_gp);
        gp.work();
        REQUIRE(gp.box.of<schema::RegionPrograms>().size() == 1);
        CHECK(gp.box.of<schema::RegionPrograms>()[0]->triangles_out() > 0);
    }

    TEST_CASE("measured isovalues have the numbers of surfaces extracted at them") {
        const std::vector<double> isovalues = {-5, 20, 100, 100.5, 180, 300};
        for (int i = 0; i < 2; ++i) {
            LoneGp gp({2, 1}, i);
            load(gp);
            gp.receive(measure(isovalues));
            gp.work();
            REQUIRE(gp.box.of<schema::IsovaluesMeasured>().size() == 1);
            const auto measured = gp.box.sent.back();
            for (std::size_t v = 0; v < isovalues.size(); ++v) {
                gp.receive(set_surface(4, static_cast<std::uint32_t>(v + 1), isovalues[v]));
                gp.work();
                const auto& built = *gp.box.of<schema::SurfaceBuilt>().back();
                const auto& curves = *measured.as<schema::IsovaluesMeasured>()->slabs();
                REQUIRE(curves.size() == built.slabs()->size());
                for (std::uint32_t s = 0; s < curves.size(); ++s) {
                    const auto* counts = curves.Get(s)->counts()->Get(static_cast<unsigned>(v));
                    const auto* slab = built.slabs()->Get(s);
                    CHECK(curves.Get(s)->slab() == slab->slab());
                    CHECK(counts->triangles() == slab->triangles());
                    CHECK(counts->area_mm2() == slab->area_mm2());
                    CHECK(counts->volume_mm3() == slab->volume_mm3());
                }
            }
        }
    }

    TEST_CASE("measuring waits behind all else, and a newer request takes its place") {
        LoneGp gp({1, 1}, 0);
        load(gp);
        std::vector<double> many(4000);
        for (std::size_t i = 0; i < many.size(); ++i) {
            many[i] = 250 * static_cast<double>(i) / 4000;
        }
        gp.receive(measure(many));
        CHECK(gp.node.work(gp.box));  // Begun, and not done.
        CHECK(gp.box.of<schema::IsovaluesMeasured>().empty());
        gp.receive(set_surface(4, 1, 100));
        for (int slab = 0; slab < n - 1; ++slab) {
            gp.node.work(gp.box);
        }
        CHECK(gp.box.of<schema::SurfaceBuilt>().size() == 1);
        gp.receive(measure({100}));
        CHECK_FALSE(gp.node.work(gp.box));
        // The replaced request has an answer, too, because the host counts the answers.
        REQUIRE(gp.box.of<schema::IsovaluesMeasured>().size() == 2);
        CHECK(gp.box.of<schema::IsovaluesMeasured>()[0]->slabs()->size() == 0);
        const auto& slabs = *gp.box.of<schema::IsovaluesMeasured>()[1]->slabs();
        CHECK(slabs.size() == n - 1);
        CHECK(slabs.Get(0)->counts()->size() == 1);
    }

    TEST_CASE("questions that a new volume drops are answered before the volume is ready") {
        LoneGp gp({1, 1}, 0);
        load(gp);
        gp.receive(set_surface(4, 7, 100));
        gp.work();
        schema::FetchMeshT fetch;
        fetch.surface = 4;
        gp.receive(bus::pack(fetch));
        gp.receive(measure({100}));
        gp.box.sent.clear();
        load(gp);
        REQUIRE(gp.box.sent.size() == 3);
        const auto* part = gp.box.sent[0].as<schema::MeshPart>();
        REQUIRE(part != nullptr);
        CHECK(part->surface() == 4);
        CHECK(part->revision() == 7);
        CHECK(part->slabs()->size() == 0);
        const auto* measured = gp.box.sent[1].as<schema::IsovaluesMeasured>();
        REQUIRE(measured != nullptr);
        CHECK(measured->slabs()->size() == 0);
        CHECK(gp.box.sent[2].as<schema::VolumeReady>() != nullptr);
    }

    TEST_CASE("a newer question about voxels takes the place of one that waits") {
        LoneGp gp({1, 1}, 0);
        load(gp);
        const auto ask = [&](schema::VoxelBox box) {
            schema::FetchVoxelsT fetch;
            fetch.volume = gp.box.of<schema::VolumeReady>().at(0)->volume();
            fetch.box = std::make_unique<schema::VoxelBox>(box);
            return bus::pack(fetch);
        };
        gp.receive(ask({0, 0, 0, 1, n, n}));
        CHECK(gp.node.work(gp.box));  // Begun, and not done.
        gp.receive(ask({3, 4, 5, 2, 3, 1}));
        gp.work();
        const auto answers = gp.box.of<schema::VoxelValues>();
        REQUIRE(answers.size() == 2);
        CHECK(answers[0]->slices()->size() == 0);
        REQUIRE(answers[1]->slices()->size() == 1);
        CHECK(answers[1]->slices()->Get(0) == 5);
        CHECK(gp.fault_of(ask({0, 0, 19, 1, 1, 2})).find("the volume has 20 x 20 x 20") !=
              std::string::npos);
    }

    TEST_CASE("isovalues cannot be measured without a volume, or without all of it") {
        LoneGp gp({1, 1}, 0);
        CHECK(gp.fault_of(measure({1, 2})) ==
              "a measurement of 2 isovalues was requested, but no volume is stored");
        gp.receive(header());
        gp.receive(measure({1}));
        CHECK(gp.fault_of_work() ==
              "a measurement of 1 isovalues was requested before all slices of volume 1 arrived");
        CHECK_FALSE(gp.node.work(gp.box));
    }

    TEST_CASE("of thresholds in quick succession no slab is extracted but the newest one's") {
        LoneGp gp({1, 1}, 0);
        load(gp);
        gp.box.sent.clear();
        std::uint32_t revision = 0;
        for (const int slabs_done : {0, 1, 7, 18}) {
            ++revision;
            gp.receive(set_surface(4, revision, 90 + 5 * revision));
            for (int slab = 0; slab < slabs_done; ++slab) {
                gp.node.work(gp.box);
            }
            CHECK(gp.box.sent.empty());  // Of 19 slabs none of the older ones was the last.
        }
        gp.receive(set_surface(4, ++revision, 100));
        CHECK(gp.work() == n - 1);
        const auto built = gp.box.of<schema::SurfaceBuilt>();
        REQUIRE(built.size() == 1);
        CHECK(built[0]->revision() == revision);
        CHECK(built[0]->slabs()->size() == n - 1);
    }

    TEST_CASE("a surface that has become small gives its memory back") {
        LoneGp gp({1, 1}, 0);
        load(gp);
        const auto loaded_bytes = gp.box.of<schema::VolumeReady>()[0]->memory_bytes();
        const auto bytes_of = [&](std::uint32_t revision, double isovalue) {
            gp.receive(set_surface(4, revision, isovalue));
            gp.work();
            return gp.box.of<schema::SurfaceBuilt>().back()->memory_bytes() - loaded_bytes;
        };
        const auto large_bytes = bytes_of(1, 80),
                   small_bytes = bytes_of(2, 150);  // 9 and 2 voxels.
        CHECK(small_bytes < large_bytes / 4);
        CHECK(bytes_of(3, 80) <= 2 * large_bytes);
        CHECK(bytes_of(4, 150) < large_bytes / 4);
    }

    TEST_CASE("a dropped volume is gone with its surfaces, its work and its memory") {
        LoneGp gp({1, 1}, 0);
        load(gp);
        const auto loaded_bytes = gp.box.of<schema::VolumeReady>()[0]->memory_bytes();
        gp.receive(set_surface(4, 1, 100));
        gp.receive(measure({100}));
        gp.receive(bus::pack(draw_frame(1, 1)));
        gp.node.work(gp.box);
        gp.receive(drop(7));  // Another one: nothing of it is here.
        gp.receive(drop(1));
        CHECK_FALSE(gp.node.work(gp.box));
        CHECK(gp.box.of<schema::SurfaceBuilt>().empty());
        REQUIRE(gp.box.of<schema::IsovaluesMeasured>().size() == 1);  // Empty: the host waits.
        CHECK(gp.box.of<schema::IsovaluesMeasured>()[0]->slabs()->size() == 0);
        CHECK(gp.box.of<schema::RegionPrograms>().size() == 1);  // Empty: Renderers wait for it.
        CHECK(gp.fault_of(set_surface(4, 2, 100)) ==
              "surface 4 was requested, but no volume is stored");
        CHECK(gp.fault_of(slices(0, 1)) ==
              "slices of volume 1 arrived, but no volume was announced");
        load(gp, 2);
        CHECK(gp.box.of<schema::VolumeReady>().back()->memory_bytes() == loaded_bytes);
    }

    TEST_CASE("half a volume can be dropped, and what came after it stays") {
        LoneGp gp({1, 1}, 0);
        gp.receive(header(1));
        gp.receive(slices(0, 5));
        gp.node.work(gp.box);
        gp.receive(drop(1));
        CHECK_FALSE(gp.node.work(gp.box));
        load(gp, 2);
        gp.receive(drop(1));
        gp.receive(set_surface(4, 1, 100));
        gp.work();
        CHECK(gp.box.of<schema::SurfaceBuilt>().size() == 1);
    }
}
