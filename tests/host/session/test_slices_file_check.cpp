// The host refuses data files that the io process could not read itself.
#include <doctest/doctest.h>
#include <fmt/core.h>
#include <stdlib.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "host/base/error.hpp"
#include "host/session/transfer/slices_file_check.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
namespace fs = std::filesystem;

namespace {

/// Files of a header, its folder and a folder beside it.
struct DataBench {
    DataBench() {
        std::string pattern = fs::temp_directory_path() / "pxpl5-test-XXXXXX";
        REQUIRE(mkdtemp(pattern.data()) != nullptr);
        top = fs::canonical(pattern);
        folder = top / "scans";
        fs::create_directories(folder / "raw");
        fs::create_directories(top / "elsewhere");
        for (const char* name :
             {"scans/scan.nhdr", "scans/image.mhd", "scans/scan.hdr", "scans/scan.vtk",
              "scans/scan.vti", "scans/scan.bin", "scans/values.raw", "scans/raw/values.raw",
              "elsewhere/values.raw"}) {
            std::ofstream(top / name) << "values";
        }
        std::ofstream(folder / "header") << "NRRD0005\n";
        fs::create_symlink(top / "elsewhere/values.raw", folder / "link.raw");
        request.path = folder / "scan.nhdr";
        request.read = ReadBy::gps;
    }
    ~DataBench() { fs::remove_all(top); }

    static SlicesFile file_at(const fs::path& path) {
        constexpr std::int64_t ns_per_s = 1'000'000'000;
        struct stat now {};
        REQUIRE(stat(path.c_str(), &now) == 0);
        SlicesFile file;
        file.path = path;
        file.facts = {static_cast<std::uint64_t>(now.st_size), now.st_ino,
                      now.st_mtim.tv_sec * ns_per_s + now.st_mtim.tv_nsec};
        return file;
    }
    std::string error_of(const SlicesFile& file,
                         const std::vector<std::string>& allowed = {}) const {
        return error_of(StoredVolume{Component::uint8, false, 0, {file}}, allowed);
    }
    std::string error_of(const StoredVolume& stored,
                         const std::vector<std::string>& allowed = {}) const {
        try {
            check_slices_files(stored, request, allowed);
        } catch (const RequestError& error) {
            CHECK(error.code == ExitCode::bad_data);
            CHECK(std::string(error.what()).starts_with(request.path + ": "));
            return error.what();
        }
        return "none";
    }
    std::string error_of(const fs::path& path, const std::vector<std::string>& allowed = {}) const {
        return error_of(file_at(path), allowed);
    }

    fs::path top, folder;
    bus::schema::ImportVolumeT request;
};

bool has(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

}  // namespace

TEST_SUITE("host/session/slices_file_check") {
    TEST_CASE("the loaded file, and data files of a header beside it or below, are accepted") {
        DataBench bench;
        for (const char* header : {"scan.nhdr", "image.mhd", "scan.hdr", "header"}) {
            CAPTURE(header);
            bench.request.path = bench.folder / header;
            CHECK(bench.error_of(bench.folder / header) == "none");
            CHECK(bench.error_of(bench.folder / "values.raw") == "none");
            CHECK(bench.error_of(bench.folder / "raw/values.raw") == "none");
        }
        bench.request.path = bench.folder / "scan.vtk";
        CHECK(bench.error_of(bench.folder / "scan.vtk") == "none");
    }

    TEST_CASE("a data file elsewhere is refused, unless its folder is allowed") {
        const DataBench bench;
        for (const fs::path& path :
             {bench.top / "elsewhere/values.raw", bench.folder / "../elsewhere/values.raw",
              bench.folder / "link.raw"}) {
            CAPTURE(path);
            CHECK(has(bench.error_of(path),
                      "its data file " + path.string() + " lies outside of the header's folder"));
            CHECK(bench.error_of(path, {bench.top / "elsewhere"}) == "none");
        }
    }

    TEST_CASE("formats that name no data file have no other file, whatever is allowed") {
        DataBench bench;
        const std::string refusal = "a file of this format has its values itself";
        for (const char* name : {"scan.vtk", "scan.vti", "scan.bin"}) {
            CAPTURE(name);
            bench.request.path = bench.folder / name;
            CHECK(has(bench.error_of(bench.folder / "values.raw", {bench.folder}), refusal));
        }
        bench.request.path = bench.folder / "scan.nhdr";
        bench.request.raw = std::make_unique<bus::schema::RawLayoutT>();
        CHECK(bench.error_of(bench.folder / "scan.nhdr") == "none");
        CHECK(has(bench.error_of(bench.folder / "values.raw", {bench.folder}), refusal));
    }

    TEST_CASE("a file is refused if the host reads the values of the request") {
        const DataBench bench;
        const auto refusal = [&](const std::function<void(bus::schema::ImportVolumeT&)>& change) {
            DataBench other;
            change(other.request);
            return other.error_of(other.folder / "scan.nhdr");
        };
        CHECK(has(refusal([](auto& request) { request.read = ReadBy::host; }), "has read=host"));
        const std::string processed = "has crop=, resample= or smooth=";
        CHECK(has(refusal([](auto& request) { request.crop_first = {0, 0, 0}; }), processed));
        CHECK(has(refusal([](auto& request) { request.resample_size = {9, 9, 9}; }), processed));
        CHECK(has(refusal([](auto& request) {
                      request.resample_spacing_mm = {1, 1, 1};
                  }),
                  processed));
        CHECK(has(refusal([](auto& request) { request.smooth_mm = 1; }), processed));
        CHECK(has(refusal([](auto& request) { request.path = "phantom:sphere"; }), "is a phantom"));
        CHECK(bench.error_of(bench.folder / "scan.nhdr") == "none");
    }

    TEST_CASE("folders, missing files and files that have changed are refused") {
        DataBench bench;
        SlicesFile changed = DataBench::file_at(bench.folder / "values.raw");
        ++changed.facts.modified_ns;
        CHECK(has(bench.error_of(changed),
                  fmt::format("changed at {} ns. Load it again", changed.facts.modified_ns)));
        CHECK(has(bench.error_of(bench.folder / "raw"), "is no regular file"));
        const auto unchanged = [](const SlicesFile& file) {
            check_unchanged({Component::uint8, false, 0, {file}}, "scan");
        };
        CHECK_THROWS_AS(unchanged(changed), RequestError);
        unchanged(DataBench::file_at(bench.folder / "values.raw"));
        changed.path = bench.folder / "missing.raw";
        CHECK_THROWS_WITH_AS(
            unchanged(changed),
            ("scan: its data file " + changed.path + ": No such file or directory").c_str(),
            RequestError);
        CHECK(has(bench.error_of(changed), "missing.raw: No such file or directory"));
        bench.request.path = bench.top / "absent";
        CHECK(has(bench.error_of(bench.folder / "values.raw"),
                  "is no regular file and no folder, but"));
    }

    TEST_CASE("a folder's files are accepted if all lie in it or below, links followed") {
        DataBench bench;
        bench.request.path = bench.folder;
        StoredVolume stored{Component::uint8, false, 0, {}};
        for (const char* name : {"scan.bin", "values.raw", "values.raw", "raw/values.raw"}) {
            stored.files.push_back(DataBench::file_at(bench.folder / name));
        }
        CHECK(bench.error_of(stored) == "none");
        stored.files.push_back(DataBench::file_at(bench.folder / "link.raw"));
        CHECK(has(bench.error_of(stored),
                  "link.raw lies outside of this folder. If the folder is "
                  "trusted, allow the folder of the data with --allow"));
        CHECK(bench.error_of(stored, {bench.top / "elsewhere"}) == "none");
        stored.files.pop_back();
        ++stored.files[2].facts.inode;  // The same path again, with other facts.
        CHECK(has(bench.error_of(stored), "values.raw has 6 bytes"));
        --stored.files[2].facts.inode;
        ++stored.files[3].facts.size_bytes;
        CHECK(has(bench.error_of(stored), "raw/values.raw has 6 bytes"));
        --stored.files[3].facts.size_bytes;
        bench.request.raw = std::make_unique<bus::schema::RawLayoutT>();
        CHECK(has(bench.error_of(stored), "raw= describes a file, and this is a folder"));
    }
}
