#include <doctest/doctest.h>

#include <array>
#include <limits>
#include <random>

#include "ringbus/ranges.hpp"
#include "tests/ringbus/wire_bytes.hpp"

using namespace pxpl5::bus;
using namespace pxpl5::test;

namespace {

schema::Matrix identity() {
    std::array<double, 16> m{};
    for (std::size_t i = 0; i < 16; i += 5) {
        m[i] = 1;
    }
    return schema::Matrix(flatbuffers::make_span(m));
}

schema::DrawFrameT good_draw() {
    schema::DrawFrameT draw;
    draw.frame = 4;
    draw.width = 300;
    draw.height = 200;
    auto view = std::make_unique<schema::ViewT>();
    view->voxel_to_eye = std::make_unique<schema::Matrix>(identity());
    view->projection = std::make_unique<schema::Matrix>(identity());
    draw.views.push_back(std::move(view));
    draw.lights.push_back(schema::Light(schema::Vec3(0, 0, 1), 0.8F));
    draw.specular_power = 20;
    draw.surfaces.push_back(schema::SurfaceDraw(1, 2, schema::Rgb(9, 8, 7), false));
    return draw;
}

schema::VolumeHeaderT good_header() {
    schema::VolumeHeaderT header;
    header.name = "v";
    header.nx = header.ny = header.nz = 4;
    header.voxel_to_patient = std::make_unique<schema::Matrix>(identity());
    return header;
}

schema::RegionProgramsT good_programs() {
    schema::RegionProgramsT programs;
    auto region = std::make_unique<schema::RegionProgramT>();
    region->words = {1, 2, 3, 4};
    region->segments = {schema::Segment(0, 0, 0, 2), schema::Segment(0, 1, 2, 2)};
    programs.regions.push_back(std::move(region));
    return programs;
}

}  // namespace

TEST_SUITE("ringbus/message") {
    TEST_CASE("what was packed is what is read") {
        const Message message = WireBytes(pack(good_draw())).read();
        CHECK(message.kind() == Body::DrawFrame);
        CHECK(message.source() == 3);
        REQUIRE(message.as<schema::DrawFrame>() != nullptr);
        CHECK(message.as<schema::DrawFrame>()->width() == 300);
        CHECK(message.as<schema::DrawFrame>()->surfaces()->Get(0)->colour().g() == 8);
        CHECK(message.as<schema::BeginFrame>() == nullptr);
    }

    TEST_CASE("a copy of a message keeps its bytes alive") {
        auto wire = std::make_unique<WireBytes>(pack(good_draw()));
        const Message copy = wire->read();
        wire.reset();
        CHECK(copy.as<schema::DrawFrame>()->height() == 200);
    }

    TEST_CASE("each damaged header field is refused by name, with both values") {
        WireBytes wire(pack(good_draw()));
        WireBytes magic = wire, version = wire, size = wire, kind = wire, other = wire;
        magic.header.mutate_magic(1);
        version.header.mutate_version(9);
        size.header.mutate_body_bytes(12);
        kind.header.mutate_kind(999);
        other.header.mutate_kind(static_cast<std::uint16_t>(Body::BeginFrame));
        CHECK(contains(refusal(magic), "magic is 1, expected 894"));
        CHECK(contains(refusal(version), "version is 9, expected 1"));
        CHECK(contains(refusal(size), "expected 12"));
        CHECK(contains(refusal(kind), "kind is 999"));
        CHECK(contains(refusal(other), "the header says BeginFrame, the body is DrawFrame"));
        CHECK(contains(refusal(kind), "from node 3"));
        CHECK(refusal(wire).empty());
    }

    TEST_CASE("every cut of a body is refused") {
        const WireBytes whole(pack(good_draw()));
        for (std::size_t size = 0; size < whole.size; size += 4) {
            WireBytes cut = whole;
            cut.size = size;
            cut.header.mutate_body_bytes(size);
            CHECK_MESSAGE(!refusal(cut).empty(), "cut to ", size, " of ", whole.size);
        }
    }

    TEST_CASE("random damage never gets past verification to a crash") {
        const WireBytes whole(pack(good_programs()));
        std::mt19937 random(20260101);
        int refused = 0;
        for (int i = 0; i < 20000; ++i) {
            WireBytes spoiled(pack(good_programs()));
            spoiled.bytes()[random() % spoiled.size] ^=
                static_cast<std::uint8_t>(1U << random() % 8);
            refused += refusal(spoiled).empty() ? 0 : 1;
        }
        CHECK(refused > 1000);
    }

    TEST_CASE("values out of range are refused by name") {
        schema::DrawFrameT draw = good_draw();
        draw.width = 0;
        CHECK(contains(refusal(pack(draw)), "width is 0"));
        draw = good_draw();
        draw.specular_power = 129;
        CHECK(contains(refusal(pack(draw)), "specular_power is 129, allowed are 1 .. 128"));
        draw = good_draw();
        draw.lights.assign(5, draw.lights.front());
        CHECK(contains(refusal(pack(draw)), "number of lights is 5"));
        draw = good_draw();
        draw.lights[0].mutable_direction().mutate_z(2);
        CHECK(contains(refusal(pack(draw)), "light's direction is 2"));
        draw = good_draw();
        draw.views.clear();
        CHECK(contains(refusal(pack(draw)), "number of views is 0"));
        draw = good_draw();
        draw.views[0]->projection->mutable_m()->Mutate(3, std::numeric_limits<double>::quiet_NaN());
        CHECK(contains(refusal(pack(draw)), "projection holds nan"));
        draw = good_draw();
        draw.ambient = std::numeric_limits<float>::quiet_NaN();
        CHECK(contains(refusal(pack(draw)), "ambient"));
    }

    TEST_CASE("an assignment has one Renderer for each region") {
        schema::BeginFrameT begin;
        begin.draw = std::make_unique<schema::DrawFrameT>(good_draw());
        begin.assignment.assign(6, 0);  // 300 x 200 pixels: 3 x 2 regions.
        CHECK(refusal(pack(begin)).empty());
        begin.assignment.pop_back();
        CHECK(contains(refusal(pack(begin)), "size of assignment is 5, expected 6"));
    }

    TEST_CASE("volumes, slices, streams, tiles and meshes hold together") {
        schema::VolumeHeaderT header = good_header();
        CHECK(refusal(pack(header)).empty());
        header.nz = 1;
        CHECK(contains(refusal(pack(header)), "nz is 1"));

        schema::SlicesT slices;
        slices.slice_count = 3;
        slices.values.resize(10);
        CHECK(contains(refusal(pack(slices)), "whole slices"));

        schema::RegionProgramsT programs = good_programs();
        CHECK(refusal(pack(programs)).empty());
        programs.regions[0]->segments[1].mutate_word_count(3);
        CHECK(contains(refusal(pack(programs)), "ends at word 5 of 4"));

        schema::RegionPixelsT pixels;
        pixels.tiles.emplace_back();
        pixels.pixels.resize(region_pixels - 1);
        CHECK(contains(refusal(pack(pixels)), "16383, expected 16384"));

        schema::MeshPartT part;
        part.slabs.push_back(std::make_unique<schema::SlabMeshT>());
        part.slabs[0]->indices = {0, 0, 0};
        CHECK(!refusal(pack(part)).empty());
        part.slabs[0]->vertices.emplace_back();
        part.slabs[0]->keys.push_back(1);
        CHECK(refusal(pack(part)).empty());
    }

    TEST_CASE("regions are counted over both views") {
        CHECK(region_count(128, 128, 1) == 1);
        CHECK(region_count(129, 128, 1) == 2);
        CHECK(region_count(1280, 1024, 1) == 80);
        CHECK(region_count(640, 512, 2) == 40);
    }
}
