#include <doctest/doctest.h>
#include <sys/resource.h>

#include <array>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "host/io/node.hpp"
#include "tests/host/io/volume_files.hpp"

using namespace pxpl5;
using namespace pxpl5::host::io;
using namespace pxpl5::test;
namespace schema = pxpl5::bus::schema;

namespace {

constexpr bus::NodeId asker = 3;

/// `payload` as the message that its receiver sees.
bus::Message received(const bus::Payload& payload, bus::NodeId from) {
    const std::span<const std::uint8_t> bytes = payload.bytes();
    const auto copy = std::make_shared<std::vector<std::uint64_t>>((bytes.size() + 7) / 8);
    std::memcpy(copy->data(), bytes.data(), bytes.size());
    const schema::Header header(bus::header_magic, bus::protocol_version,
                                static_cast<std::uint16_t>(payload.kind()), from, 0, 0, 0, 0,
                                bytes.size(), 0, 0, 0);
    return {header, {reinterpret_cast<const std::uint8_t*>(copy->data()), bytes.size()}, copy};
}

class Inbox final : public bus::Outbox {
  public:
    using bus::Outbox::send;
    void send(bus::NodeId to, bus::Payload payload) override {
        CHECK(to == asker);
        messages.push_back(received(payload, 0));
    }
    std::vector<bus::Message> messages;
};

std::vector<bus::Message> answers_to(IoNode& node, const bus::Payload& request) {
    Inbox inbox;
    node.receive(received(request, asker), inbox);
    CHECK(inbox.messages.empty());  // Long work is for work().
    while (node.work(inbox)) {
    }
    return inbox.messages;
}

bus::Payload import_request(const std::string& path) {
    schema::ImportVolumeT request;
    request.path = path;
    return bus::pack(request);
}

/// A MetaImage of 1024 x 1024 x 11 uint8: slices of 1 MiB, four to a message.
std::string large_meta_image() {
    std::string values;
    for (char slice = 0; slice < 11; ++slice) {
        values += std::string(std::size_t{1024} * 1024, static_cast<char>('a' + slice));
    }
    return "ObjectType = Image\nNDims = 3\nDimSize = 1024 1024 11\nOffset = 1 2 3\n"
           "ElementSpacing = 0.5 1 2\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n" +
           values;
}

}  // namespace

TEST_SUITE("host/io/node") {
    TEST_CASE("an import is answered by a header, whole slices in order, and an end") {
        const TemporaryFolder folder;
        IoNode node({0, 0});
        const std::vector<bus::Message> got =
            answers_to(node, import_request(folder.write("large.mha", large_meta_image())));
        REQUIRE(got.size() == 5);
        const auto* header = got[0].as<schema::VolumeHeader>();
        REQUIRE(header != nullptr);
        CHECK(header->name()->str() == "large");
        CHECK(header->nx() == 1024);
        CHECK(header->nz() == 11);
        CHECK(header->type() == Scalar::uint8);
        CHECK(header->minimum() == 'a');
        CHECK(header->maximum() == 'k');
        CHECK(header->voxel_to_patient()->m()->Get(0) == 0.5);
        CHECK(header->voxel_to_patient()->m()->Get(10) == 2);
        CHECK(header->voxel_to_patient()->m()->Get(14) == 3);
        std::uint32_t next = 0;
        for (std::size_t index = 1; index < 4; ++index) {
            const auto* slices = got[index].as<schema::Slices>();
            REQUIRE(slices != nullptr);
            CHECK(slices->volume() == header->volume());
            CHECK(slices->first_slice() == next);
            CHECK(slices->values()->size() == slices->slice_count() * 1024 * 1024);
            CHECK(slices->values()->Get(0) == 'a' + next);
            next += slices->slice_count();
            CHECK(slices->values()->Get(slices->values()->size() - 1) == 'a' + next - 1);
        }
        CHECK(next == 11);
        REQUIRE(got[4].as<schema::VolumeEnd>() != nullptr);
        CHECK(got[4].as<schema::VolumeEnd>()->volume() == header->volume());
    }

    TEST_CASE("volumes of a series follow each other, up to the end of the series") {
        const TemporaryFolder folder;
        const std::string head =
            "ObjectType = Image\nNDims = 4\nDimSize = 2 2 2 4\n"
            "ElementSpacing = 1 1 1 1\nElementType = MET_UCHAR\n"
            "ElementDataFile = LOCAL\n";
        schema::ImportVolumeT request;
        request.path = folder.write("beat.mha", head + "aaaaaaaabbbbbbbbccccccccdddddddd");
        request.frame = 2;
        request.volumes = 2;
        IoNode node({0, 0});
        std::vector<bus::Message> got = answers_to(node, bus::pack(request));
        REQUIRE(got.size() == 6);
        for (std::size_t volume = 0; volume < 2; ++volume) {
            const auto* header = got[3 * volume].as<schema::VolumeHeader>();
            const auto* slices = got[3 * volume + 1].as<schema::Slices>();
            const auto* end = got[3 * volume + 2].as<schema::VolumeEnd>();
            REQUIRE((header != nullptr && slices != nullptr && end != nullptr));
            CHECK(header->frame() == volume + 2);
            CHECK(header->frames() == 4);
            CHECK(slices->volume() == header->volume());
            CHECK(slices->values()->Get(0) == 'b' + volume);
            CHECK(end->volume() == header->volume());
        }
        CHECK(got[0].as<schema::VolumeHeader>()->volume() !=
              got[3].as<schema::VolumeHeader>()->volume());
        request.volumes = 100;
        CHECK(answers_to(node, bus::pack(request)).size() == 9);
        request.path = folder.write("cut.mha", head + "aaaaaaaabbbbbbbbcccccccc");
        got = answers_to(node, bus::pack(request));
        REQUIRE(got.size() == 7);  // Volumes 2 and 3.
        REQUIRE(got[6].as<schema::IoDone>() != nullptr);
        CHECK(!got[6].as<schema::IoDone>()->ok());
        CHECK(got[6].as<schema::IoDone>()->error()->str().find("volume 4 of 4") !=
              std::string::npos);
    }

    TEST_CASE("an archive is answered by its content, in the millimeters of its picture") {
        const TemporaryFolder folder;
        schema::ReadArchiveT request;
        request.path = folder.write("a.phigs",
                                    "structure s posted {\n"
                                    "color sphere { diff 1 2 3 128 spec 51 51 51 40 };\n"
                                    "sphere 5 0 0 1; sphere 7 0 0 1;\n"
                                    "color line { diff 4 5 6 255 }; line 2 { 6 0 1; 6 1 0; }; };");
        IoNode node({0, 0});
        const std::vector<bus::Message> got = answers_to(node, bus::pack(request));
        REQUIRE(got.size() == 2);
        const auto* content = got[0].as<schema::ArchiveContent>();
        REQUIRE(content != nullptr);
        CHECK(content->materials()->size() == 2);
        CHECK(content->materials()->Get(0)->color().b() == 3);
        CHECK(content->low()->x() == 4);
        CHECK(content->high()->x() == 8);
        CHECK(content->posted() == 1);
        CHECK(content->specular() == doctest::Approx(0.2));
        CHECK(content->specular_power() == 40);
        REQUIRE(content->notes()->size() == 1);
        CHECK(content->notes()->Get(0)->str() == "translucent colors, drawn opaque: 1");
        REQUIRE(content->parts()->size() == 2);
        const auto& spheres = *content->parts()->Get(0)->spheres();
        REQUIRE(spheres.size() == 2);  // The scene's radius of 2 is shown as 100 mm.
        CHECK(spheres.Get(0)->x() == -50);
        CHECK(spheres.Get(1)->x() == 50);
        CHECK(spheres.Get(1)->radius() == 50);
        const schema::SceneLine& line = *content->parts()->Get(1)->lines()->Get(0);
        CHECK(line.ay() == -50);  // The archive's z, towards the viewer: anterior.
        CHECK(line.bz() == 50);   // The archive's y: up.
        CHECK(got[1].as<schema::IoDone>()->ok());
    }

    TEST_CASE("an archive that cannot be read is answered by the reason, file and place included") {
        const TemporaryFolder folder;
        schema::ReadArchiveT request;
        request.path = folder.write("a.phigs", "structure s posted { sphere 0 0 0; }");
        IoNode node({0, 0});
        std::vector<bus::Message> got = answers_to(node, bus::pack(request));
        REQUIRE(got.size() == 1);
        const auto* done = got[0].as<schema::IoDone>();
        REQUIRE(done != nullptr);
        CHECK(!done->ok());
        CHECK(done->bad_data());
        CHECK(done->error()->str() == request.path + ":1:34: found ';', expected radius, a number");
        request.path = folder.file("none.phigs");
        got = answers_to(node, bus::pack(request));
        REQUIRE(got.size() == 1);
        CHECK(got[0].as<schema::IoDone>()->error()->str() ==
              request.path + ": cannot be opened: No such file or directory");
    }

    TEST_CASE("all that a request asks for reaches the import, and findings come back") {
        const TemporaryFolder folder;
        IoNode node({0, 0});
        schema::ImportVolumeT request;
        std::string bytes = "ab";
        for (int i = 0; i < 6 * 5 * 4; ++i) {
            bytes.push_back(static_cast<char>(1));
            bytes.push_back(static_cast<char>(i));  // Big endian: 256 + i.
        }
        request.path = folder.write("v.bin", bytes);
        request.raw = std::make_unique<schema::RawLayoutT>();
        request.raw->nx = 6;
        request.raw->ny = 5;
        request.raw->nz = 4;
        request.raw->type = "int16";
        request.raw->big_endian = true;
        request.raw->offset = 2;
        request.spacing_mm = {1, 2, 3};
        request.crop_first = {1, 1, 1};
        request.crop_size = {5, 3, 3};
        request.resample_size = {9, 3, 3};
        const std::vector<bus::Message> got = answers_to(node, bus::pack(request));
        REQUIRE(got.size() == 3);
        const auto* header = got[0].as<schema::VolumeHeader>();
        CHECK(header->nx() == 9);
        CHECK(header->nz() == 3);
        CHECK(header->source()->str() == request.path);
        CHECK(header->voxel_to_patient()->m()->Get(0) == 0.5);
        CHECK(header->voxel_to_patient()->m()->Get(12) == 1);
        CHECK(header->voxel_to_patient()->m()->Get(14) == 3);
        CHECK(header->minimum() == 256 + 30 + 6 + 1);
        // Two assumptions: spacing and place; two things done.
        REQUIRE(header->findings()->size() == 4);
        CHECK(header->findings()->Get(1)->kind() == FindingKind::assumption);
        CHECK(header->findings()->Get(2)->kind() == FindingKind::processed);
        request.resample_size.clear();
        request.resample_spacing_mm = {2, 2, 3};
        request.smooth_mm = 1.5;
        const std::vector<bus::Message> smooth = answers_to(node, bus::pack(request));
        REQUIRE(smooth.size() == 3);
        CHECK(smooth[0].as<schema::VolumeHeader>()->nx() == 3);
        CHECK(smooth[0].as<schema::VolumeHeader>()->findings()->size() == 5);
        request.series = "2";
        request.raw.reset();
        request.path = folder.write("v.nrrd", "NRRD0004");
        const std::vector<bus::Message> refused = answers_to(node, bus::pack(request));
        REQUIRE(refused.size() == 1);
        CHECK(refused[0].as<schema::IoDone>()->error()->str().find("series is '2'") !=
              std::string::npos);
        CHECK(refused[0].as<schema::IoDone>()->bad_data());
    }

    TEST_CASE("a file that cannot be imported is answered by its complaint, and the node goes on") {
        const TemporaryFolder folder;
        IoNode node({0, 0});
        const std::vector<bus::Message> bad =
            answers_to(node, import_request(folder.file("gone.nrrd")));
        REQUIRE(bad.size() == 1);
        const auto* done = bad[0].as<schema::IoDone>();
        REQUIRE(done != nullptr);
        CHECK(!done->ok());
        CHECK(done->bad_data());
        CHECK(done->error()->str() == folder.file("gone.nrrd") + ": No such file or directory");
        CHECK(answers_to(node, import_request(folder.write("large.mha", large_meta_image())))
                  .size() == 5);
    }

    TEST_CASE("an export writes the picture and says so, or why not") {
        const TemporaryFolder folder;
        IoNode node({0, 0});
        schema::ExportPictureT request;
        request.path = folder.file("p.png");
        request.width = 2;
        request.height = 1;
        request.rgba = {255, 0, 0, 255, 0, 255, 0, 255};
        request.description = "two pixels";
        const std::vector<bus::Message> good = answers_to(node, bus::pack(request));
        REQUIRE(good.size() == 1);
        CHECK(good[0].as<schema::IoDone>()->ok());
        CHECK(std::filesystem::file_size(folder.file("p.png")) > 50);
        // Marks, attributes and the number of pictures come through.
        const auto error = [&] {
            const std::vector<bus::Message> answer = answers_to(node, bus::pack(request));
            REQUIRE(answer.size() == 1);
            CHECK(!answer[0].as<schema::IoDone>()->ok());
            return answer[0].as<schema::IoDone>()->error()->str();
        };
        request.marks.push_back(std::make_unique<schema::MarkT>());
        request.marks[0]->kind = MarkKind::text;
        request.marks[0]->points = {{0, 0}};
        request.marks[0]->color = std::make_unique<schema::Rgba>(1, 2, 3, 255);
        request.marks[0]->text = "\xff";
        CHECK(error().find("mark 0 (text") != std::string::npos);
        request.marks.clear();
        request.attributes.push_back(std::make_unique<schema::AttributeT>());
        request.attributes[0]->name = "bad name";
        CHECK(error().find("'bad name'") != std::string::npos);
        request.attributes.clear();
        request.rgba.resize(16);
        request.count = 2;
        CHECK(error().find("2 pictures need an animation") != std::string::npos);
        request.delay_ms = 5;
        request.path = folder.file("p.gif");
        CHECK(error().find("5 ms between pictures") != std::string::npos);
        request.path = folder.file("p.unknown");
        request.rgba.resize(8);
        request.count = 1;
        const std::vector<bus::Message> bad = answers_to(node, bus::pack(request));
        REQUIRE(bad.size() == 1);
        CHECK(!bad[0].as<schema::IoDone>()->ok());
        CHECK(bad[0].as<schema::IoDone>()->error()->str().find("suffix is '.unknown'") !=
              std::string::npos);
    }

    TEST_CASE("each picture of an animation may take as long as a request") {
        const TemporaryFolder folder;
        constexpr rlim_t long_s = 100'000;
        IoNode node({0, long_s});
        schema::ExportPictureT request;
        request.path = folder.file("a.gif");
        request.width = request.height = 2;
        request.count = 3;
        request.rgba.resize(48, 255);
        const auto limit_s = [&] {
            const std::vector<bus::Message> answer = answers_to(node, bus::pack(request));
            REQUIRE(answer.size() == 1);
            CHECK(answer[0].as<schema::IoDone>()->ok());
            rlimit cpu{};
            getrlimit(RLIMIT_CPU, &cpu);
            return cpu.rlim_cur;
        };
        CHECK(limit_s() / long_s == 3);
        request.count = 1;
        request.rgba.resize(16);
        CHECK(limit_s() / long_s == 1);
    }

    TEST_CASE("a mesh is written from the message, and the answer counts its triangles") {
        const TemporaryFolder folder;
        IoNode node({0, 0});
        schema::ExportMeshT request;
        request.path = folder.file("m.ply");
        request.axes = PatientAxes::RAS;
        request.description = "one triangle";
        request.surfaces.push_back(std::make_unique<schema::ExportSurfaceT>());
        schema::ExportSurfaceT& surface = *request.surfaces[0];
        surface.name = "bone";
        surface.color = std::make_unique<schema::Rgb>(1, 2, 3);
        surface.vertices = {{1, 2, 3, 0, 0, 1}, {4, 2, 3, 0, 0, 1}, {1, 5, 3, 0, 0, 1}};
        surface.indices = {0, 1, 2};
        const std::vector<bus::Message> answer = answers_to(node, bus::pack(request));
        REQUIRE(answer.size() == 1);
        const auto* done = answer[0].as<schema::IoDone>();
        REQUIRE(done != nullptr);
        CHECK(done->ok());
        CHECK(done->triangles() == 1);
        CHECK(done->text()->str() == "1 triangles, 3 vertices, RAS millimeters");
        std::ifstream stream(folder.file("m.ply"), std::ios::binary);
        const std::string bytes(std::istreambuf_iterator<char>(stream), {});
        const std::size_t body = bytes.find("end_header\n") + 11;
        CHECK(bytes.size() == body + 3 * 27 + 14);
        std::array<float, 6> vertex{};
        std::memcpy(vertex.data(), bytes.data() + body, sizeof vertex);
        CHECK(vertex == std::array<float, 6>{-1, -2, 3, 0, 0, 1});
        CHECK(bytes.find("comment one triangle\n") != std::string::npos);

        request.keep = 0;
        const std::vector<bus::Message> bad = answers_to(node, bus::pack(request));
        REQUIRE(bad.size() == 1);
        CHECK(!bad[0].as<schema::IoDone>()->ok());
        CHECK(bad[0].as<schema::IoDone>()->error()->str().find("share of triangles") !=
              std::string::npos);
    }

    TEST_CASE("requests are served in order, and too many are refused") {
        const TemporaryFolder folder;
        IoNode node({0, 0});
        Inbox inbox;
        for (std::size_t index = 0; index < max_requests; ++index) {
            node.receive(received(import_request(folder.file("v" + std::to_string(index))), asker),
                         inbox);
        }
        CHECK_THROWS_AS(node.receive(received(import_request("v"), asker), inbox), bus::NodeFault);
        while (node.work(inbox)) {
        }
        REQUIRE(inbox.messages.size() == max_requests);
        const auto text = [&](std::size_t index) {
            return inbox.messages[index].as<schema::IoDone>()->error()->str();
        };
        CHECK(text(0).find("/v0:") != std::string::npos);
        CHECK(text(63).find("/v63:") != std::string::npos);
    }

    TEST_CASE("what the node does not serve is a fault that names it") {
        IoNode node({0, 0});
        Inbox inbox;
        CHECK_THROWS_WITH_AS(node.receive(received(bus::pack(schema::VolumeEndT{}), asker), inbox),
                             doctest::Contains("VolumeEnd"), bus::NodeFault);
    }
}
