// Kinds of DICOM image that hold something else than one slice or slices one behind another.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>

#include "host/io/import.hpp"
#include "tests/host/io/dicom_files.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using namespace pxpl5::host::io;
using namespace pxpl5::test;

namespace {

bool reports(const Volume& volume, FindingKind kind, const std::string& words) {
    return std::any_of(volume.findings.begin(), volume.findings.end(), [&](const Finding& f) {
        return f.kind == kind && f.text.find(words) != std::string::npos;
    });
}

std::string complaint(const TemporaryFolder& folder, const std::string& bytes) {
    try {
        import_volume(folder.write("x.dcm", bytes));
    } catch (const ImportError& error) {
        return std::string(error.what()).substr(folder.file("x.dcm: ").size());
    }
    return "";
}

std::int16_t value_at(const Volume& volume, std::size_t index) {
    std::int16_t value = 0;
    std::memcpy(&value, volume.values.data() + 2 * index, 2);
    return value;
}

/// Three frames that state neither positions nor a distance.
DicomSet frames() {
    DicomSet set = dicom_image(4, 4, std::string(3 * 32, '\1'));
    set.text(8, 0x60, "CS", "US").text(0x28, 8, "IS", "3");
    return set.text(0x28, 0x30, "DS", "1\\1");
}

std::string tag_value(std::uint16_t group, std::uint16_t element) {
    return bytes_of(group) + bytes_of(element);
}

}  // namespace

TEST_SUITE("host/io/dicom_kinds") {
    TEST_CASE("a Siemens mosaic is as many slices as its CSA header says, each in its place") {
        const TemporaryFolder folder;
        const Volume volume = import_volume(folder.write("x.dcm", mosaic().file()));
        REQUIRE(std::array{volume.nx, volume.ny, volume.nz} == std::array{3, 2, 3});
        for (std::size_t slice = 0; slice < 3; ++slice) {
            for (std::size_t i = 0; i < 6; ++i) {
                CHECK(value_at(volume, 6 * slice + i) == static_cast<int>(10 * slice + i));
            }
        }
        // The position of the file is that of the whole picture about the same center.
        CHECK(volume.voxel_to_patient[3] == glm::dvec4(1 + 2 * 1.5, 2 + 4 * 1.0, 3, 1));
        CHECK(volume.voxel_to_patient[0] == glm::dvec4(2, 0, 0, 0));
        CHECK(volume.voxel_to_patient[1] == glm::dvec4(0, 4, 0, 0));
        CHECK(volume.voxel_to_patient[2] == glm::dvec4(0, 0, 5, 0));
        CHECK(reports(volume, FindingKind::note, "Siemens mosaic of 3 slices"));
    }

    TEST_CASE("slices of a mosaic lie along the normal of its CSA header") {
        const TemporaryFolder folder;
        DicomSet set = mosaic();
        set.put(0x29, 0x1010, "OB",
                csa_header({csa_field("NumberOfImagesInMosaic", {"3"}),
                            csa_field("SliceNormalVector", {"0", "0", "-1"})}));
        const Volume volume = import_volume(folder.write("x.dcm", set.file()));
        REQUIRE(volume.nz == 3);
        CHECK(volume.voxel_to_patient[2] == glm::dvec4(0, 0, 5, 0));
        CHECK(volume.voxel_to_patient[3].z == 3 - 10);
        CHECK(value_at(volume, 0) == 20);
        CHECK(value_at(volume, 12) == 0);
    }

    TEST_CASE("a mosaic that does not say where its slices are is refused by name") {
        const TemporaryFolder folder;
        const auto refused = [&](DicomSet set, const std::string& reason) {
            const std::string text = complaint(folder, set.file());
            CAPTURE(text);
            CHECK(text.find("is a Siemens mosaic") == 0);
            CHECK(text.find(reason) != std::string::npos);
            CHECK(text.find("export it as one image per slice") != std::string::npos);
        };
        refused(mosaic().remove(0x29, 0x1010), "no CSA header");
        refused(mosaic().remove(0x18, 0x88), "(0018,0088)");
        refused(mosaic().remove(0x20, 0x32), "0020,0032");
        refused(mosaic().put(0x29, 0x1010, "OB",
                             csa_header({csa_field("NumberOfImagesInMosaic", {"5"}),
                                         csa_field("SliceNormalVector", {"0", "0", "1"})})),
                "5 slices");
        refused(mosaic().put(0x29, 0x1010, "OB",
                             csa_header({csa_field("NumberOfImagesInMosaic", {"3"}),
                                         csa_field("SliceNormalVector", {"1", "0", "0"})})),
                "normal");
        const std::string whole = csa_header({csa_field("NumberOfImagesInMosaic", {"3"}),
                                              csa_field("SliceNormalVector", {"0", "0", "1"})});
        for (std::size_t size = 0; size < whole.size(); size += 22) {
            refused(mosaic().put(0x29, 0x1010, "OB", whole.substr(0, size)), "CSA header");
        }
    }

    TEST_CASE("frames that follow each other in time are refused, and no spacing is asked for") {
        const TemporaryFolder folder;
        for (const auto element : {std::uint16_t{0x1063}, std::uint16_t{0x1065}}) {
            DicomSet set = frames();
            set.put(0x28, 9, "AT", tag_value(0x18, element)).text(0x18, element, "DS", "33.3");
            const std::string text = complaint(folder, set.file());
            CAPTURE(text);
            CHECK(text.find("its 3 frames are a time series") == 0);
            CHECK(text.find("spacing=") == std::string::npos);
            ImportRequest request;
            request.path = folder.file("x.dcm");
            request.spacing_mm = glm::dvec3(1, 1, 1);
            CHECK_THROWS_WITH_AS(import_volume(request), doctest::Contains("a time series"),
                                 ImportError);
        }
        DicomSet set = frames();
        set.put(0x28, 9, "AT", tag_value(0x54, 0x80));
        CHECK(complaint(folder, set.file()).find("give spacing=x,y,z") != std::string::npos);
        set = frames();
        CHECK(complaint(folder, set.text(0x18, 0x1063, "DS", "40").file())
                  .find("its 3 frames are a time series") == 0);
        // Cine without an increment pointer.
        set = frames();
        CHECK(complaint(folder, set.text(0x18, 0x40, "IS", "30").file())
                  .find("its 3 frames are a time series, since Cine Rate (0018,0040)") == 0);
        set = frames();
        CHECK(complaint(folder, set.text(8, 0x2144, "IS", "30").file())
                  .find("its 3 frames are a time series, since Recommended Display Frame Rate "
                        "(0008,2144)") == 0);
    }

    TEST_CASE("segmentations, parametric maps and directories are refused by what they are") {
        const TemporaryFolder folder;
        DicomSet set = dicom_image(4, 4, std::string(32, '\1'));
        set.text(8, 0x16, "UI", "1.2.840.10008.5.1.4.1.1.66.4").text(8, 0x60, "CS", "SEG");
        CHECK(complaint(folder, set.file()).find("is a segmentation (SEG)") == 0);
        set = dicom_image(4, 4, "");
        set.remove(0x7fe0, 0x10).put(0x7fe0, 8, "OF", std::string(64, '\0'));
        CHECK(complaint(folder, set.file()).find("holds float pixels (7fe0,0008)") == 0);
        set = dicom_image(4, 4, std::string(32, '\1'));
        CHECK(complaint(folder, set.number(0x28, 0x10, 0).file()) ==
              "has 0 rows (0028,0010), must be 2 to 4096");
        DicomSet directory;
        directory.text(4, 0x1130, "CS", "DISK").sequence(4, 0x1220, {});
        CHECK(complaint(folder, directory.file()).find("is a DICOMDIR, a list of files") == 0);
    }

    TEST_CASE("files of a folder that cannot be read are left out, and a finding names each") {
        const TemporaryFolder folder;
        const auto slice = [](double z_mm) {
            DicomSet set = dicom_image(4, 4, std::string(32, '\1'));
            return dicom_place(set, {0, 0, z_mm}, {1, 0, 0}, {0, 1, 0}, 1, 1);
        };
        for (const int z : {0, 1, 2, 4}) {
            folder.write("s" + std::to_string(z), slice(z).file());
        }
        const std::string whole = slice(3).file();
        folder.write("s3", whole.substr(0, whole.size() - 10));
        DicomSet colored = slice(2.5);
        colored.number(0x28, 2, 3).text(0x28, 4, "CS", "RGB");
        folder.write("t", colored.put(0x7fe0, 0x10, "OW", std::string(96, 'x')).file());
        const Volume volume = import_volume(folder.file(""));
        CHECK(volume.nz == 4);
        CHECK(reports(volume, FindingKind::missing_slices,
                      "s3: pixel data (7fe0,0010) have 22 bytes, 4x4x1 of 2 bytes need 32: "
                      "this file is left out"));
        CHECK(reports(volume, FindingKind::missing_slices, "t: samples per pixel"));
        DicomSet directory;
        folder.write("DICOMDIR", directory.sequence(4, 0x1220, {}).file());
        folder.write("cine", frames().put(0x28, 9, "AT", tag_value(0x18, 0x1063)).file());
        CHECK(reports(import_volume(folder.file("")), FindingKind::other_series,
                      "cine: its 3 frames are a time series"));
        CHECK(reports(import_volume(folder.file("")), FindingKind::note,
                      "1 file is not a DICOM image"));
        folder.write("u", slice(9).text(0x20, 0xe, "UI", "1.2.9").file());
        CHECK_THROWS_WITH_AS(import_volume(folder.file("")), doctest::Contains("holds 2 series"),
                             ImportError);
        const TemporaryFolder broken;
        broken.write("s3", whole.substr(0, whole.size() - 10));
        CHECK_THROWS_WITH_AS(import_volume(broken.file("")), doctest::Contains("have 22 bytes"),
                             ImportError);
    }
}
