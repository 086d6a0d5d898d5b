// DICOM series in ZIP and tar archives: the volume is that of the unpacked folder.
#include <doctest/doctest.h>

#include <algorithm>
#include <clocale>
#include <cstring>
#include <filesystem>

#include "host/io/dicom/dicom_attributes.hpp"
#include "host/io/dicom/thumbnail.hpp"
#include "tests/host/io/packed/packed_series.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using namespace pxpl5::host::io;
using namespace pxpl5::test;
namespace fs = std::filesystem;

namespace {

/// The files in a folder, beside what lies around in archives of scanners and of file managers.
NamedBytes disk() {
    NamedBytes files = {{"DICOM/", ""}, {"DICOMDIR", dicom_slice(grid(), 0).file()}};
    for (const auto& [name, bytes] : series()) {
        files.emplace_back("DICOM/" + name, bytes);
    }
    files.emplace_back("__MACOSX/DICOM/._IM1", "\5\26\7");
    files.emplace_back("empty", "");
    return files;
}

}  // namespace

TEST_SUITE("host/io/packed") {
    TEST_CASE("a series in an archive of each kind is that of the unpacked folder") {
        const TemporaryFolder folder;
        fs::create_directories(folder.file("scan/DICOM"));
        fs::create_directories(folder.file("scan/__MACOSX/DICOM"));
        for (const auto& [name, bytes] : disk()) {
            if (!name.ends_with('/')) {
                folder.write("scan/" + name, bytes);
            }
        }
        const Volume unpacked = read(folder.file("scan"));
        REQUIRE(unpacked.nz == 4);
        for (const ArchiveKind& kind : kinds) {
            CAPTURE(kind.name);
            CAPTURE(kind.compression);
            const TemporaryFolder own;
            const std::string path =
                own.write(kind.name, packed(disk(), kind.format, kind.compression, kind.options));
            const Volume volume = read(path);
            CHECK(volume.values == unpacked.values);
            CHECK(volume.voxel_to_patient == unpacked.voxel_to_patient);
            CHECK(volume.series == unpacked.series);
            CHECK(volume.name == "scan");
            CHECK(volume.source == path);
            CHECK(volume.findings == unpacked.findings);
            REQUIRE(!volume.findings.empty());
            CHECK(volume.findings.back().text == "3 files are not DICOM images and are left out");
            const fs::path around = fs::path(path).parent_path();
            CHECK(std::distance(fs::directory_iterator(around), {}) == 1);  // Nothing is written.
        }
    }

    TEST_CASE("of an archive with several series the one that is asked for is read") {
        const TemporaryFolder folder;
        NamedBytes files;
        for (const char* const uid : {"1.2.3", "1.2.4"}) {
            for (const auto& [name, bytes] : series(uid)) {
                files.emplace_back(std::string(uid) + "/" + name, bytes);
            }
        }
        ImportRequest request;
        request.path = folder.write("scan.zip", packed(files));
        CHECK(refusal(request.path).find("1.2.4") != std::string::npos);
        request.series = "1.2.4";
        CHECK(import_volume(request).series == "1.2.4");
        const auto all = series_of(find_slices(request.path, {}));
        REQUIRE(all.size() == 2);
        CHECK(all[1].front().path == request.path + "/1.2.4/IM1");
    }

    TEST_CASE("attributes and picture of a slice in an archive are those of the stored file") {
        const TemporaryFolder folder;
        const NamedBytes files = series();
        const std::string stored = folder.write("IM1", files[0].second);
        const std::string path = folder.write("scan.zip", packed(files));
        const std::vector<DicomSlice> slices = find_slices(path, {});
        REQUIRE(slices.size() == 4);
        const DicomAttributes expected = read_attributes(stored);
        const DicomAttributes found = read_attributes(slices[0].input());
        REQUIRE(found.all.size() == expected.all.size());
        CHECK(found.value(0x0020, 0x0032) == expected.value(0x0020, 0x0032));
        CHECK(thumbnail_of(slices[0], std::nullopt).pixels ==
              thumbnail_of(find_slices(stored, {})[0], std::nullopt).pixels);
    }

    TEST_CASE("names that lead out of the archive stay names") {
        const TemporaryFolder folder;
        NamedBytes files = series();
        files[0].first = "/etc/passwd";
        files[1].first = "../../IM";
        files[2].first = "new\nline";
        files[3].first = "new\tline";
        const std::string path = folder.write("scan.tar", packed(files, ARCHIVE_FORMAT_TAR_USTAR));
        CHECK(read(path).values == read(folder.write("plain.zip", packed(series()))).values);
        std::vector<std::string> names;
        for (const DicomSlice& slice : find_slices(path, {})) {
            names.push_back(slice.path.string().substr(path.size()));
        }
        CHECK(names == std::vector<std::string>{"/../../IM", "/etc/passwd", "/new?line",
                                                "/new?line (earlier file 1)"});
    }

    TEST_CASE("a file of the archive that cannot be read is left out by name") {
        const TemporaryFolder folder;
        NamedBytes files = series();
        files.emplace_back("half", files[0].second.substr(0, 300));
        const std::string path = folder.write("scan.zip", packed(files));
        const Volume volume = read(path);
        CHECK(volume.nz == 4);
        REQUIRE(!volume.findings.empty());
        CHECK(volume.findings.front().text.starts_with(path + "/half: "));
        CHECK(volume.findings.front().text.ends_with(": this file is left out"));
    }

    TEST_CASE("volumes of a time series in an archive are read one after the other") {
        const TemporaryFolder folder;
        NamedBytes files;
        for (int frame = 1; frame <= 2; ++frame) {
            for (int z = 0; z < 4; ++z) {
                Grid moved = grid();
                moved.values[0] = static_cast<std::int16_t>(1000 * frame);
                DicomSet set = dicom_slice(moved, z);
                set.text(0x20, 0x100, "IS", std::to_string(frame));
                files.emplace_back(std::to_string(files.size()), set.file());
            }
        }
        ImportRequest request;
        request.path = folder.write("scan.zip", packed(files));
        Importer importer(request);
        for (const std::uint32_t frame : {1U, 2U}) {
            const Volume volume = importer.read(frame);
            CHECK(volume.frames == 2);
            std::int16_t first = 0;
            std::memcpy(&first, volume.values.data(), sizeof first);
            CHECK(first == static_cast<int>(1000 * frame));
        }
    }

    TEST_CASE("files with one name are all read, and said") {
        const TemporaryFolder folder;
        NamedBytes files = series();
        const Volume expected = read(folder.write("plain.zip", packed(files)));
        for (auto& [name, bytes] : files) {
            name = "IM";
        }
        for (const int format : {ARCHIVE_FORMAT_ZIP, ARCHIVE_FORMAT_TAR_USTAR}) {
            CAPTURE(format);
            const Volume volume = read(folder.write("scan.any", packed(files, format)));
            CHECK(volume.values == expected.values);
            REQUIRE(!volume.findings.empty());
            CHECK(volume.findings.back().text ==
                  "3 files have the name of a later file in the archive");
        }
    }

    TEST_CASE("zeros that a sparse file leaves out are there, also the last ones") {
        const TemporaryFolder folder;
        Grid large{{256, 256, 2}, glm::dmat4(1.0), std::vector<std::int16_t>(2 * 256 * 256)};
        large.values[5] = large.values[256 * 256 + 7] = 1000;
        const NamedBytes files = {{"IM1", dicom_slice(large, 0).file()},
                                  {"IM2", dicom_slice(large, 1).file()}};
        constexpr std::size_t stored = 65'536;
        const std::string sparse = packed(files, ARCHIVE_FORMAT_TAR_PAX_INTERCHANGE,
                                          ARCHIVE_FILTER_NONE, nullptr, nullptr, 1, stored);
        REQUIRE(sparse.size() < files[0].second.size() + files[1].second.size());
        CHECK(read(folder.write("sparse.tar", sparse)).values ==
              read(folder.write("plain.zip", packed(files))).values);
    }

    TEST_CASE("a link is counted, and not followed") {
        const TemporaryFolder folder;
        NamedBytes files = series();
        files.emplace_back("IM9 -> /etc/passwd", "");
        for (const int format : {ARCHIVE_FORMAT_ZIP, ARCHIVE_FORMAT_TAR_USTAR}) {
            CAPTURE(format);
            const Volume volume = read(folder.write("scan.any", packed(files, format)));
            CHECK(volume.nz == 4);
            REQUIRE(!volume.findings.empty());
            CHECK(volume.findings.back().text == "1 link in the archive is not followed");
        }
    }

    TEST_CASE("names beyond ASCII are kept") {
        const TemporaryFolder folder;
        std::setlocale(LC_CTYPE, "C.UTF-8");  // As main() of pxpl5-io.
        for (const int format :
             {ARCHIVE_FORMAT_ZIP, ARCHIVE_FORMAT_TAR_USTAR, ARCHIVE_FORMAT_TAR_PAX_INTERCHANGE}) {
            CAPTURE(format);
            const std::string bytes = packed({{"Sch\u00e4del/\u982d", series()[0].second}}, format);
            const std::string path = folder.write("scan.zip", bytes);
            const auto slices = find_slices(path, {});
            REQUIRE(slices.size() == 1);
            CHECK(slices[0].path == path + "/Sch\u00e4del/\u982d");
        }
        std::setlocale(LC_CTYPE, "C");
    }
}
