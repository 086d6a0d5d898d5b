// DICOM files as bytes, read through GDCM.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>

#include "host/io/import.hpp"
#include "tests/host/io/volume_writers.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using namespace pxpl5::host::io;
using namespace pxpl5::test;

using namespace std::string_literals;

namespace {

constexpr int columns = 6, rows = 4;

bool reports(const Volume& volume, FindingKind kind, const std::string& words) {
    return std::any_of(volume.findings.begin(), volume.findings.end(), [&](const Finding& f) {
        return f.kind == kind && f.text.find(words) != std::string::npos;
    });
}

std::vector<std::int16_t> plane(int value) {
    std::vector<std::int16_t> values(columns * rows, static_cast<std::int16_t>(value));
    values[1] = static_cast<std::int16_t>(value + 1);
    return values;
}

/// A slice at height z_mm, whose pixels are 0.5 mm wide and 0.75 mm high.
DicomSet slice_at(double z_mm, int value) {
    DicomSet set = dicom_image(columns, rows, bytes_of(plane(value)));
    return dicom_place(set, {1, 2, z_mm}, {1, 0, 0}, {0, 1, 0}, 0.5, 0.75);
}

/// An enhanced file whose frame i lies at heights[i].
DicomSet enhanced(const std::vector<double>& heights) {
    std::string values;
    std::vector<DicomSet> frames;
    for (std::size_t i = 0; i < heights.size(); ++i) {
        values += bytes_of(plane(static_cast<int>(10 * i)));
        DicomSet position, transformation, frame;
        position.text(0x20, 0x32, "DS", dicom_numbers({1, 2, heights[i]}));
        transformation.text(0x28, 0x1052, "DS", "-5").text(0x28, 0x1053, "DS", "2");
        frame.sequence(0x20, 0x9113, {position}).sequence(0x28, 0x9145, {transformation});
        frames.push_back(frame);
    }
    DicomSet orientation, measures, shared;
    orientation.text(0x20, 0x37, "DS", "1\\0\\0\\0\\0\\-1");
    measures.text(0x28, 0x30, "DS", "0.75\\0.5").text(0x18, 0x50, "DS", "3");
    shared.sequence(0x20, 0x9116, {orientation}).sequence(0x28, 0x9110, {measures});
    DicomSet set = dicom_image(columns, rows, values);
    set.text(0x28, 8, "IS", std::to_string(heights.size()));
    return set.sequence(0x5200, 0x9229, {shared}).sequence(0x5200, 0x9230, frames);
}

std::int16_t value_at(const Volume& volume, std::size_t index) {
    std::int16_t value = 0;
    std::memcpy(&value, volume.values.data() + 2 * index, 2);
    return value;
}

std::string complaint(const TemporaryFolder& folder, const std::string& bytes) {
    try {
        import_volume(folder.write("x.dcm", bytes));
    } catch (const ImportError& error) {
        return std::string(error.what()).substr(folder.file("x.dcm: ").size());
    }
    return "";
}

}  // namespace

TEST_SUITE("host/io/dicom_files") {
    TEST_CASE("rows and columns have their own spacing, in the order of the standard") {
        const TemporaryFolder folder;
        const Volume volume = import_volume(folder.write("x.dcm", slice_at(3, 40).file()));
        CHECK(std::array{volume.nx, volume.ny, volume.nz} == std::array{columns, rows, 1});
        CHECK(volume.voxel_to_patient[0] == glm::dvec4(0.5, 0, 0, 0));
        CHECK(volume.voxel_to_patient[1] == glm::dvec4(0, 0.75, 0, 0));
        CHECK(volume.voxel_to_patient[3] == glm::dvec4(1, 2, 3, 1));
        CHECK(value_at(volume, 1) == 41);
        CHECK(volume.modality == "CT");
        CHECK(volume.name == "x");
    }

    TEST_CASE("frames have their own positions and slopes, and are sorted by them") {
        const TemporaryFolder folder;
        // Normal of x (1,0,0) and y (0,0,-1) is (0,1,0): heights are along z, so place along y.
        DicomSet set = enhanced({0, 0, 0});
        std::vector<DicomSet> frames;
        for (const double y : {6.0, 0.0, 3.0}) {
            DicomSet position, transformation, frame;
            position.text(0x20, 0x32, "DS", dicom_numbers({1, y, 2}));
            transformation.text(0x28, 0x1052, "DS", "-5").text(0x28, 0x1053, "DS", "2");
            frame.sequence(0x20, 0x9113, {position}).sequence(0x28, 0x9145, {transformation});
            frames.push_back(frame);
        }
        set.sequence(0x5200, 0x9230, frames);
        const Volume volume = import_volume(folder.write("x.dcm", set.file()));
        REQUIRE(volume.nz == 3);
        CHECK(volume.voxel_to_patient[0] == glm::dvec4(0.5, 0, 0, 0));
        CHECK(volume.voxel_to_patient[1] == glm::dvec4(0, 0, -0.75, 0));
        CHECK(volume.voxel_to_patient[2] == glm::dvec4(0, 3, 0, 0));
        CHECK(volume.voxel_to_patient[3] == glm::dvec4(1, 0, 2, 1));
        REQUIRE(volume.type == Scalar::int16);
        // Frames 1, 2, 0 hold 10, 20, 0, doubled less five.
        CHECK(value_at(volume, 0) == 15);
        CHECK(value_at(volume, columns * rows) == 35);
        CHECK(value_at(volume, 2 * columns * rows) == -5);
    }

    TEST_CASE("frames at one position are a series of times: the first is read, and that is said") {
        const TemporaryFolder folder;
        const Volume volume = import_volume(folder.write("x.dcm", enhanced({0, 0, 0}).file()));
        CHECK(volume.nz == 1);
        CHECK(reports(volume, FindingKind::duplicate_slices, "2 slices have the position"));
    }

    TEST_CASE("frames without positions are never silently 1 mm apart") {
        const TemporaryFolder folder;
        DicomSet set = enhanced({0, 1, 2});
        set.remove(0x5200, 0x9230);
        CHECK(complaint(folder, set.file()).find("give spacing=x,y,z in millimeters") !=
              std::string::npos);
        set.text(0x18, 0x88, "DS", "2.5");
        const Volume volume = import_volume(folder.write("x.dcm", set.file()));
        CHECK(volume.voxel_to_patient[2] == glm::dvec4(0, 2.5, 0, 0));
        CHECK(reports(volume, FindingKind::assumption, "taken as 2.5 mm apart (0018,0088)"));
    }

    TEST_CASE("frames of a dose lie at their offsets, uneven ones too, and are scaled") {
        const TemporaryFolder folder;
        DicomSet set = enhanced({0, 0, 0, 0});
        set.remove(0x5200, 0x9230).remove(0x5200, 0x9229);
        dicom_place(set, {1, 2, 10}, {1, 0, 0}, {0, 1, 0}, 0.5, 0.75);
        set.text(0x3004, 0xc, "DS", "0\\2\\4\\10").text(0x3004, 0xe, "DS", "0.5");
        const Volume volume = import_volume(folder.write("x.dcm", set.file()));
        CHECK(volume.slice_places == std::vector<double>{0, 1, 2, 5});
        CHECK(volume.gap_slabs == std::vector<int>{2});
        CHECK(volume.voxel_to_patient[3].z == 10);
        CHECK(volume.maximum == 15.5);
    }

    TEST_CASE("a missing slice in a folder leaves a gap, and the rest where it is") {
        const TemporaryFolder folder;
        for (const int z : {0, 1, 2, 4, 5}) {
            folder.write("s" + std::to_string(z), slice_at(2.0 * z, z).file());
        }
        const Volume volume = import_volume(folder.file(""));
        CHECK(volume.slice_places == std::vector<double>{0, 1, 2, 4, 5});
        CHECK(volume.gap_slabs == std::vector<int>{2});
        CHECK(reports(volume, FindingKind::missing_slices, "4.000 mm from s2 to s4"));
    }

    TEST_CASE("a slice more than a million steps from the others is refused") {
        const TemporaryFolder folder;
        for (const double z_mm : {0.0, 0.001, 0.002, 1000.5}) {
            folder.write("s" + std::to_string(z_mm), slice_at(z_mm, 1).file());
        }
        CHECK_THROWS_WITH_AS(import_volume(folder.file("")),
                             doctest::Contains("its last slice lies 1000500"), ImportError);
    }

    TEST_CASE("whether spacing is stated is asked of the series that is chosen, not of others") {
        const TemporaryFolder folder;
        const auto series = [&](const char* uid, int z, bool stated) {
            DicomSet set = slice_at(2.0 * z, z).text(0x20, 0xe, "UI", uid);
            folder.write(uid + std::to_string(z), (stated ? set : set.remove(0x28, 0x30)).file());
        };
        for (const int z : {0, 1}) {
            series("1.2.3", z, true);
            series("1.2.4", z, false);
        }
        ImportRequest request;
        request.path = folder.file("");
        request.series = "1.2.3";
        const Volume stated = import_volume(request);
        CHECK(stated.voxel_to_patient[0].x == 0.5);
        CHECK_FALSE(reports(stated, FindingKind::assumption, ""));
        request.spacing_mm = glm::dvec3(3, 3, 3);
        CHECK_THROWS_WITH_AS(import_volume(request), doctest::Contains("states its spacing"),
                             ImportError);
        request.series = "1.2.4";
        const Volume asked = import_volume(request);
        CHECK(asked.voxel_to_patient[0].x == 3);
        CHECK(asked.voxel_to_patient[2].z == 2);
        CHECK(reports(asked, FindingKind::note, "along xy: taken as asked for"));
    }

    TEST_CASE("folders inside the folder are looked into, and two series in them are listed") {
        const TemporaryFolder folder;
        std::filesystem::create_directories(folder.file("a/b"));
        folder.write("a/one", slice_at(0, 1).file());
        folder.write("a/b/two", slice_at(2, 2).file());
        folder.write("a/notes.txt", "words");
        CHECK(import_volume(folder.file("")).nz == 2);
        folder.write("a/b/other", slice_at(4, 3).text(0x20, 0xe, "UI", "1.2.9").file());
        CHECK_THROWS_WITH_AS(import_volume(folder.file("")), doctest::Contains("holds 2 series"),
                             ImportError);
        ImportRequest request;
        request.path = folder.file("");
        request.series = "1.2.9";
        CHECK(import_volume(request).minimum == 3);
    }

    TEST_CASE("slope and intercept count whatever the modality") {
        const TemporaryFolder folder;
        DicomSet set = slice_at(0, 100);
        set.text(8, 0x60, "CS", "MR").text(0x28, 0x1053, "DS", "0.125");
        set.text(0x28, 0x1052, "DS", "-1");
        const Volume volume = import_volume(folder.write("x.dcm", set.file()));
        CHECK(volume.minimum == 11.5);
        CHECK(volume.maximum == 101 * 0.125 - 1);
        CHECK(volume.type == Scalar::float32);
    }

    TEST_CASE("of 12 bits stored in 16 the twelfth is the sign, and what is above is no value") {
        const TemporaryFolder folder;
        std::vector<std::int16_t> stored(columns * rows, 0x07ff);
        stored[1] = 0x0fff;
        stored[2] = 0x0800;
        DicomSet set = slice_at(0, 0);
        set.number(0x28, 0x101, 12).number(0x28, 0x102, 11);
        set.put(0x7fe0, 0x10, "OW", bytes_of(stored));
        const Volume volume = import_volume(folder.write("x.dcm", set.file()));
        CHECK(value_at(volume, 0) == 2047);
        CHECK(value_at(volume, 1) == -1);
        CHECK(value_at(volume, 2) == -2048);
    }

    TEST_CASE("headers that make no sense are refused with field and value") {
        const TemporaryFolder folder;
        const std::string whole = slice_at(0, 1).file();
        CHECK(complaint(folder, whole.substr(0, whole.size() - 10)) ==
              "pixel data (7fe0,0010) have 38 bytes, 6x4x1 of 2 bytes need 48");
        DicomSet set = slice_at(0, 1);
        CHECK(complaint(folder, set.text(0x28, 0x30, "DS", "0\\0.5").file()) ==
              "pixel spacing (0028,0030) is 0 and 0.5, must be two lengths above 0");
        set = slice_at(0, 1);
        CHECK(complaint(folder, set.text(0x20, 0x37, "DS", "1\\0\\0\\1\\0\\0").file()) ==
              "the rows and columns of (0020,0037) meet at a cosine of 1, must be 0");
        set = slice_at(0, 1);
        CHECK(complaint(folder, set.text(0x28, 0x1053, "DS", "0").file())
                  .find("rescale slope (0028,1053) is 0") == 0);
        set = slice_at(0, 1);
        CHECK(complaint(folder, set.number(0x28, 0x10, 60'000).file()) ==
              "has 60000 rows (0028,0010), must be 2 to 4096");
        set = slice_at(0, 1);
        CHECK(complaint(folder, set.text(0x28, 8, "IS", "99999999").file()) ==
              "number of frames (0028,0008) is 99999999, must be 1 to 65536");
        set = slice_at(0, 1);
        set.number(0x28, 2, 3).text(0x28, 4, "CS", "RGB");
        set.put(0x7fe0, 0x10, "OW", std::string(3 * 48, 'x'));
        CHECK(complaint(folder, set.file()) ==
              "samples per pixel (0028,0002) are 3, must be 1: color is not read");
    }

    TEST_CASE("elements that do not fit into the file are refused before GDCM sees them") {
        const TemporaryFolder folder;
        const std::string whole = slice_at(0, 1).file();
        std::string bytes = whole;
        const std::size_t modality = bytes.find("CS", bytes.find("\x08\0\x60\0"s)) - 4;
        bytes.replace(modality + 4, 2, "#!");
        CHECK(complaint(folder, bytes) ==
              fmt::format("element (0008,0060) at byte {} is of type '#!', which DICOM does not "
                          "know",
                          modality));
        bytes = whole;
        constexpr std::size_t group_length = 140;  // The value of (0002,0000), and its end below.
        bytes.resize(group_length + 4 + static_cast<unsigned char>(bytes[group_length]));
        CHECK(complaint(folder, bytes) == "ends with its meta information, without a data set");
        bytes = whole;
        const std::size_t rows = bytes.find("\x28\0\x10\0US"s);
        bytes.replace(rows + 4, 2, "CS");
        CHECK(complaint(folder, bytes) ==
              fmt::format("element (0028,0010) at byte {} is of type CS instead of US", rows));
        bytes = whole;
        bytes.replace(modality + 6, 2, "\xff\x7f");
        CHECK(complaint(folder, bytes) ==
              fmt::format("element (0008,0060) at byte {} has a length of 32767 bytes, {} are left",
                          modality, bytes.size() - modality - 8));
        bytes = whole;
        bytes.replace(bytes.size() - 52, 4, "\0\0\0\x7f"s);
        CHECK(complaint(folder, bytes) ==
              "pixel data (7fe0,0010) state 2130706432 bytes, 48 are left");
        const std::string frames = enhanced({0, 1, 2}).file();
        const std::size_t item = frames.find("\xfe\xff\x00\xe0"s);
        bytes = frames;
        bytes[item + 2] = 0x0d;  // The end of an item.
        CHECK(complaint(folder, bytes).find("stands where an item of a sequence must be") !=
              std::string::npos);
        std::string deep;
        for (int i = 0; i < 40; ++i) {
            deep += "\x40\0\x60\xa7SQ\0\0\xff\xff\xff\xff\xfe\xff\0\xe0\xff\xff\xff\xff"s;
        }
        DicomSet none;
        CHECK(complaint(folder, none.file() + deep).find("is nested more than 32 deep") !=
              std::string::npos);
    }

    TEST_CASE("a DICOM file without an image is no image") {
        const TemporaryFolder folder;
        DicomSet set;
        set.text(8, 0x60, "CS", "SR").text(0x20, 0xe, "UI", "1.2");
        CHECK(complaint(folder, set.file()).find("is no DICOM image") == 0);
    }
}
