// Requests to an io node that confines its process, each in a child.
#include <doctest/doctest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "host/base/kernel/protections.hpp"
#include "host/io/node.hpp"
#include "host/io/request_needs.hpp"
#include "host/io/sandbox/sanitizer.hpp"
#include "host/io/survey.hpp"
#include "tests/host/io/dicom_files.hpp"
#include "tests/host/io/sandbox/confined.hpp"
#include "tests/host/io/volume_files.hpp"

using namespace pxpl5;
using namespace pxpl5::host::io;
using namespace pxpl5::test;
namespace fs = std::filesystem;
namespace schema = pxpl5::bus::schema;

namespace {

bus::Message received(const bus::Payload& payload) {
    const std::span<const std::uint8_t> bytes = payload.bytes();
    const auto copy = std::make_shared<std::vector<std::uint64_t>>((bytes.size() + 7) / 8);
    std::memcpy(copy->data(), bytes.data(), bytes.size());
    const schema::Header header(bus::header_magic, bus::protocol_version,
                                static_cast<std::uint16_t>(payload.kind()), bus::host_id, 0, 0, 0,
                                0, bytes.size(), 0, 0, 0);
    return {header, {reinterpret_cast<const std::uint8_t*>(copy->data()), bytes.size()}, copy};
}

/// Notes the answers as text on standard error.
class Report final : public bus::Outbox {
  public:
    using bus::Outbox::send;
    void send(bus::NodeId, bus::Payload payload) override {
        const bus::Message message = received(payload);
        const auto* header = message.as<schema::VolumeHeader>();
        if (header != nullptr && header->findings() != nullptr) {
            for (const schema::Finding* finding : *header->findings()) {
                std::fprintf(stderr, "finding: %s\n", finding->text()->c_str());
            }
        }
        const auto* done = message.as<schema::IoDone>();
        const std::string text = done != nullptr && done->error() ? done->error()->str() : "";
        std::fprintf(stderr, "%s %s\n", bus::kind_name(message.kind()).c_str(), text.c_str());
    }
};

/// How a confined node answers the request.
std::string answer_to(const bus::Payload& request, const std::vector<std::string>& allowed = {}) {
    const Ending ending = in_child([&] {
        IoNode node({0, 0}, allowed, true);
        Report report;
        node.receive(received(request), report);
        while (node.work(report)) {
        }
        try {
            node.receive(received(request), report);
        } catch (const bus::NodeFault& fault) {
            std::fprintf(stderr, "second: %s\n", fault.what());
        }
        return 0;
    });
    CHECK(ending.signal == 0);
    return ending.log;
}

/// The lines of a confined process that answers the question of the words.
std::string survey_of(const std::vector<std::string>& words,
                      const std::vector<std::string>& allowed) {
    const Ending ending = in_child([&] {
        dup2(STDERR_FILENO, STDOUT_FILENO);
        return serve_survey(take_survey(words).value(), {allowed, {0, 0}, true});
    });
    CHECK(ending.signal == 0);
    return ending.log;
}

bus::Payload import_of(const std::string& path) {
    schema::ImportVolumeT request;
    request.path = path;
    return bus::pack(request);
}

bool has(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

std::string header_of(const std::string& data) {
    return "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nspacings: 1 1 1\nencoding: raw\n"
           "data file: " +
           data + "\n";
}

DicomSet slice_at(double z_mm) {
    DicomSet set = dicom_image(2, 2, std::string(8, 'v'));
    return dicom_place(set, {0, 0, z_mm}, {1, 0, 0}, {0, 1, 0}, 1, 1);
}

}  // namespace

TEST_SUITE("host/io/confined_requests") {
    TEST_CASE("a confined process reads a header, the data beside it, and allowed folders") {
        const TemporaryFolder scan, other;
        scan.write("data.raw", "abcdefgh");
        other.write("data.raw", "abcdefgh");
        const std::string near = scan.write("near.nhdr", header_of("data.raw"));
        const std::string far = scan.write("far.nhdr", header_of(other.file("data.raw")));
        CHECK(has(answer_to(import_of(near)), "VolumeEnd"));
        CHECK(has(answer_to(import_of(far)), "--allow DIR"));
        CHECK(has(answer_to(import_of(far), {other.file("")}), "VolumeEnd"));
    }

    TEST_CASE("a confined process serves one request") {
        CHECK(has(answer_to(import_of("phantom:sphere")), "second: the sandbox"));
    }

    TEST_CASE("a confined process names the file that a misspelled path means") {
        const TemporaryFolder folder;
        folder.write("scan.nii", NiftiHeader().bytes());
        CHECK(has(answer_to(import_of(folder.file("scam.nii"))), "did you mean scan.nii?"));
    }

    TEST_CASE("a confined process reads an archive") {
        const TemporaryFolder folder;
        schema::ReadArchiveT request;
        request.path = folder.write("a.phigs", "structure s posted { sphere 0 0 0 1; }");
        const std::string answer = answer_to(bus::pack(request));
        CHECK_MESSAGE(has(answer, "ArchiveContent \nIoDone \nsecond: the sandbox"), answer);
        const auto files = needs_of(received(bus::pack(request)), {}).files;
        CHECK(files.readable.front() == request.path);
        CHECK(files.writable.empty());
    }

    TEST_CASE("a confined process writes a picture with text, and a mesh") {
        const TemporaryFolder folder;
        for (const char* name : {"p.png", "p.tif", "p.exr", "p.svg", "p.pdf"}) {
            schema::ExportPictureT request;
            request.path = folder.file(name);
            request.width = request.height = 64;
            request.rgba.resize(std::size_t{64} * 64 * 4, 255);
            request.marks.push_back(std::make_unique<schema::MarkT>());
            request.marks[0]->kind = MarkKind::text;
            request.marks[0]->points = {{8, 8}};
            request.marks[0]->color = std::make_unique<schema::Rgba>(1, 2, 3, 255);
            request.marks[0]->text = "text";
            CHECK(has(answer_to(bus::pack(request)), "IoDone \n"));
            CHECK(fs::file_size(folder.file(name)) > 50);
        }
        schema::ExportMeshT mesh;
        mesh.path = folder.file("m.obj");
        mesh.surfaces.push_back(std::make_unique<schema::ExportSurfaceT>());
        mesh.surfaces[0]->color = std::make_unique<schema::Rgb>(1, 2, 3);
        mesh.surfaces[0]->vertices = {{1, 2, 3, 0, 0, 1}, {4, 2, 3, 0, 0, 1}, {1, 5, 3, 0, 0, 1}};
        mesh.surfaces[0]->indices = {0, 1, 2};
        CHECK(has(answer_to(bus::pack(mesh)), "IoDone \n"));
        CHECK(fs::exists(folder.file("m.mtl")));
        schema::ReadMeshT read;
        read.path = folder.file("m.obj");
        CHECK(has(answer_to(bus::pack(read)), "MeshContent"));
    }

    TEST_CASE("a confined process writes where a link of the output leads") {
        const TemporaryFolder base, far;
        fs::create_symlink(far.file("p.png"), base.file("p.png"));
        fs::create_symlink(far.file("other.obj"), base.file("m.obj"));
        schema::ExportPictureT picture;
        picture.path = base.file("p.png");
        picture.width = picture.height = 2;
        picture.rgba.resize(16, 255);
        const auto folders = needs_of(received(bus::pack(picture)), {}).files.writable;
        CHECK(folders == std::vector<fs::path>{fs::path(far.file("p.png")).parent_path()});
        const std::string answer = answer_to(bus::pack(picture));
        CHECK_MESSAGE(has(answer, "IoDone \n"), answer);
        schema::ExportMeshT mesh;
        mesh.path = base.file("m.obj");
        mesh.surfaces.push_back(std::make_unique<schema::ExportSurfaceT>());
        mesh.surfaces[0]->color = std::make_unique<schema::Rgb>(1, 2, 3);
        mesh.surfaces[0]->vertices = {{1, 2, 3, 0, 0, 1}, {4, 2, 3, 0, 0, 1}, {1, 5, 3, 0, 0, 1}};
        mesh.surfaces[0]->indices = {0, 1, 2};
        const std::string written = answer_to(bus::pack(mesh));
        CHECK_MESSAGE(has(written, "IoDone \n"), written);
        CHECK(fs::is_symlink(base.file("p.png")));
        CHECK(fs::is_symlink(base.file("m.obj")));
        CHECK(fs::is_regular_file(far.file("p.png")));
        CHECK(fs::is_regular_file(far.file("other.obj")));
        CHECK(fs::is_regular_file(base.file("m.mtl")));  // The name that the OBJ file states.
    }

    TEST_CASE("links of a DICOM folder are followed inside it and into allowed folders") {
        const TemporaryFolder base;
        const auto name = [&base](const char* part) { return base.file(part); };
        fs::create_directories(name("scan/deep"));
        fs::create_directory(name("elsewhere"));
        base.write("scan/0.dcm", slice_at(0).file());
        base.write("scan/deep/1.dcm", slice_at(1).file());
        base.write("elsewhere/secret.dcm", slice_at(2).file());
        fs::create_symlink(name("elsewhere/secret.dcm"), name("scan/2.dcm"));
        const std::string refused = answer_to(import_of(name("scan")));
        CHECK(has(refused, "VolumeEnd"));
        CHECK(has(refused, "scan/2.dcm: is a link to " + name("elsewhere/secret.dcm")));
        CHECK(has(refused, "--allow DIR"));
        const std::string allowed = answer_to(import_of(name("scan")), {name("elsewhere")});
        CHECK_MESSAGE(has(allowed, "VolumeEnd"), allowed);
        CHECK(!has(allowed, "is a link to"));
    }

    TEST_CASE("a confined process lists series inside its folder and in allowed folders") {
        const TemporaryFolder base;
        const auto name = [&base](const char* part) { return base.file(part); };
        fs::create_directory(name("scan"));
        fs::create_directory(name("elsewhere"));
        base.write("scan/0.dcm", slice_at(0).text(8, 0x103e, "LO", "Knee").file());
        base.write("scan/1.dcm", slice_at(1).text(8, 0x103e, "LO", "Knee").file());
        base.write("scan/broken.dcm", slice_at(2).file().substr(0, 300));
        base.write("elsewhere/secret.dcm", slice_at(2).text(8, 0x103e, "LO", "Knee").file());
        fs::create_symlink(name("elsewhere/secret.dcm"), name("scan/2.dcm"));
        const std::string two = survey_of({"pxpl5-io", "--series", name("scan")}, {});
        CHECK_MESSAGE(has(two, R"("description":"Knee")"), two);
        CHECK(has(two, R"("slices":2,)"));
        CHECK(has(two, R"({"thumbnail":0,"width":2,"height":2,"pixels":")"));
        CHECK(has(two, R"({"done":true})"));
        const std::string three =
            survey_of({"pxpl5-io", "--series", name("scan")}, {name("elsewhere")});
        CHECK_MESSAGE(has(three, R"("slices":3,)"), three);
        const auto attributes = [&](const std::string& path, const std::string& uid) {
            return survey_of({"pxpl5-io", "--attributes", path, "series=" + uid}, {});
        };
        CHECK(has(attributes(name("scan"), "1.2.3"), R"(,"SeriesDescription","LO","Knee",false])"));
        CHECK(has(attributes(name("scan"), "1.2.4"), "holds no DICOM slices of series 1.2.4"));
        CHECK(has(attributes(name("none"), "1.2.3"), "none"));
    }

    TEST_CASE("attributes of one of several series without a UID are refused") {
        const TemporaryFolder folder;
        for (const char* description : {"Hip", "Knee"}) {
            folder.write(description,
                         slice_at(0).text(8, 0x103e, "LO", description).remove(0x20, 0xe).file());
        }
        const std::string path = fs::path(folder.file("x")).parent_path().string();
        const std::string refused = survey_of({"pxpl5-io", "--attributes", path, "series="}, {});
        CHECK_MESSAGE(has(refused, "several series without a UID (0020,000e)"), refused);
        CHECK(has(survey_of({"pxpl5-io", "--series", path}, {}), R"("number":2,"uid":"")"));
    }

    TEST_CASE("other words are no question, and a UID is no option") {
        using Words = std::vector<std::string>;
        CHECK(take_survey({"pxpl5-io", "--attributes", "/a", "series=--no-sandbox"})->series ==
              "--no-sandbox");
        for (const Words& words : {Words{"pxpl5-io"},
                                   {"pxpl5-io", "--series"},
                                   {"pxpl5-io", "--attributes", "/a"},
                                   {"pxpl5-io", "--attributes", "/a", "1.2"},
                                   {"pxpl5-io", "--serie", "/a"},
                                   {"pxpl5-io", "--series", "/a", "series="}}) {
            CAPTURE(words.size());
            CHECK(!take_survey(words));
        }
    }

    TEST_CASE("a request needs its own file or folder, and nothing else of the user's") {
        const TemporaryFolder folder;
        const std::string one = folder.write("a.dcm", slice_at(0).file());
        const std::string header = folder.write("a.nhdr", header_of("data.raw"));
        const auto is_needed = [](const bus::Payload& request, const fs::path& path) {
            const Needs needs = needs_of(received(request), {"/allowed"});
            return std::ranges::find(needs.files.readable, path) != needs.files.readable.end();
        };
        CHECK(is_needed(import_of(one), one));
        CHECK(!is_needed(import_of(one), folder.file("").substr(0, folder.file("").size() - 1)));
        CHECK(!is_needed(import_of(one), "/allowed"));
        CHECK(is_needed(import_of(header), fs::path(header).parent_path()));
        CHECK(is_needed(import_of(header), "/allowed"));
        schema::ExportPictureT picture;
        picture.path = folder.file("p.png");
        picture.width = 25;
        picture.height = 10;
        picture.rgba.resize(1000);
        const Needs needs = needs_of(received(bus::pack(picture)), {});
        CHECK(needs.task == Task::write);
        REQUIRE(needs.files.writable.size() == 1);
        CHECK(needs.files.writable[0] == fs::path(one).parent_path());
        CHECK(needs.file_bytes > 16'000);
    }
}
