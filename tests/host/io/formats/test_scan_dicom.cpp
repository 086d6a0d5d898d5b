// DICOM slices that GPs read from their files: the same voxels as those that the host reads.
#include <doctest/doctest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "gp_firmware/volume/stored_slices.hpp"
#include "host/io/dicom/dicom_file.hpp"
#include "host/io/formats/scan_values.hpp"
#include "host/io/import.hpp"
#include "tests/host/io/formats/gp_shape.hpp"
#include "tests/host/io/volume_writers.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using namespace pxpl5::host::io;
using namespace pxpl5::test;
namespace fs = std::filesystem;

namespace {

constexpr int columns = 7, rows = 5;
constexpr std::size_t pixels = std::size_t{columns} * rows;

ImportRequest request_for(const std::string& path, ReadBy read) {
    ImportRequest request;
    request.path = path;
    request.read = read;
    return request;
}

/// Checks that the host and the GPs get the same volume. Returns where the GPs read it.
StoredVolume check_same(const std::string& path) {
    CAPTURE(path);
    const Volume whole = import_volume(request_for(path, ReadBy::host));
    const Volume scanned = import_volume(request_for(path, ReadBy::gps));
    CHECK(scanned.type == whole.type);
    CHECK(scanned.minimum == whole.minimum);
    CHECK(scanned.maximum == whole.maximum);
    CHECK(scanned.values == whole.values);
    CHECK(scanned.voxel_to_patient == whole.voxel_to_patient);
    CHECK(scanned.slice_places == whole.slice_places);
    CHECK(scanned.series == whole.series);
    std::vector<Finding> findings = scanned.findings;
    const auto is_ours = [](const Finding& finding) {
        return finding.text.starts_with("the GPs read the values from ");
    };
    CHECK(std::erase_if(findings, is_ours) == 1);
    CHECK(findings == whole.findings);
    REQUIRE(scanned.stored);
    gp::StoredSlices slices(shape_of(scanned), *scanned.stored);
    const std::size_t bytes = whole.values.size() / static_cast<std::size_t>(whole.nz);
    for (int z = whole.nz - 1; z >= 0; --z) {
        const auto slice = slices.read(z);
        CHECK(std::equal(slice.begin(), slice.end(),
                         whole.values.begin() + static_cast<std::ptrdiff_t>(bytes) * z));
    }
    slices.check();
    return *scanned.stored;
}

std::string refusal(const std::string& path) {
    try {
        import_volume(request_for(path, ReadBy::gps));
    } catch (const ImportError& error) {
        return error.what();
    }
    return "none";
}

bool has(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

/// Values that use all bits, so that each bit that is lost shows.
template <typename T>
std::string values_of(int slice) {
    std::string bytes;
    for (std::size_t i = 0; i < pixels; ++i) {
        bytes += bytes_of(static_cast<T>(2'654'435'761U * (i + 1 + pixels * std::size_t(slice))));
    }
    return bytes;
}

template <typename T>
DicomSet slice_at(double z_mm, int slice) {
    constexpr auto bits = static_cast<std::uint16_t>(8 * sizeof(T));
    DicomSet set = dicom_image(columns, rows, values_of<T>(slice));
    set.number(0x28, 0x100, bits).number(0x28, 0x101, bits).number(0x28, 0x102, bits - 1);
    set.number(0x28, 0x103, std::is_signed_v<T> ? 1 : 0);
    return dicom_place(set, {1, 2, z_mm}, {1, 0, 0}, {0, 1, 0}, 0.5, 0.75);
}

/// Four files whose order by name is not that of their places. `change` gets each set and its
/// number.
template <typename T, typename Change>
std::string series(const TemporaryFolder& folder, Change change) {
    fs::create_directory(folder.file("series"));
    for (const int slice : {0, 1, 2, 3}) {
        DicomSet set = slice_at<T>(30 - 2.5 * slice, slice);
        change(set, slice);
        folder.write("series/" + std::to_string(slice) + ".dcm", set.file());
    }
    return folder.file("series");
}

/// One file whose frame i lies at heights[i].
DicomSet multi_frame(const std::vector<double>& heights) {
    std::string values;
    std::vector<DicomSet> frames;
    for (std::size_t i = 0; i < heights.size(); ++i) {
        values += values_of<std::int16_t>(static_cast<int>(i));
        DicomSet position, frame;
        position.text(0x20, 0x32, "DS", dicom_numbers({1, 2, heights[i]}));
        frames.push_back(frame.sequence(0x20, 0x9113, {position}));
    }
    DicomSet orientation, measures, shared;
    orientation.text(0x20, 0x37, "DS", "1\\0\\0\\0\\1\\0");
    measures.text(0x28, 0x30, "DS", "0.75\\0.5");
    shared.sequence(0x20, 0x9116, {orientation}).sequence(0x28, 0x9110, {measures});
    DicomSet set = dicom_image(columns, rows, values);
    set.text(0x28, 8, "IS", std::to_string(heights.size()));
    return set.sequence(0x5200, 0x9229, {shared}).sequence(0x5200, 0x9230, frames);
}

const auto unchanged = [](DicomSet&, int) {};

}  // namespace

TEST_SUITE("host/io/scan_dicom") {
    TEST_CASE("a series has the same voxels for all types of values, and a place for each file") {
        const auto check = []<typename T>(T) {
            const TemporaryFolder folder;
            const StoredVolume stored = check_same(series<T>(folder, unchanged));
            REQUIRE(stored.files.size() == 4);
            CHECK(stored.files[0].path == folder.file("series/3.dcm"));
            CHECK(component_bytes(stored.component) == sizeof(T));
        };
        check(std::uint8_t{});
        check(std::int8_t{});
        check(std::uint16_t{});
        check(std::int16_t{});
        check(std::uint32_t{});
        check(std::int32_t{});
    }

    TEST_CASE("bits that are not in use are cleared, and each slice has its own scale") {
        const TemporaryFolder folder;
        const auto check = [&](int sign, int bits, const char* slope) {
            fs::remove_all(folder.file("series"));
            const StoredVolume stored =
                check_same(series<std::int16_t>(folder, [&](DicomSet& set, int slice) {
                    const auto stored_bits = static_cast<std::uint16_t>(bits);
                    set.number(0x28, 0x101, stored_bits).number(0x28, 0x102, stored_bits - 1);
                    set.number(0x28, 0x103, static_cast<std::uint16_t>(sign));
                    set.text(0x28, 0x1053, "DS", slice == 2 ? slope : "1");
                    set.text(0x28, 0x1052, "DS", "0");
                }));
            CHECK(stored.bits_stored == bits);
            CHECK(stored.files[1].scale.slope == std::stod(slope));
        };
        for (const int sign : {0, 1}) {
            for (const int bits : {12, 16, 9}) {
                for (const char* slope : {"1", "0.25", "3"}) {
                    CAPTURE(sign);
                    CAPTURE(bits);
                    CAPTURE(slope);
                    check(sign, bits, slope);
                }
            }
        }
    }

    TEST_CASE("bytes and words with bits that are not in use, odd lengths, and inverted grays") {
        const auto check = []<typename T>(T, std::uint16_t bits) {
            const TemporaryFolder folder;
            const StoredVolume stored = check_same(series<T>(folder, [&](DicomSet& set, int) {
                set.number(0x28, 0x101, bits).number(0x28, 0x102, bits - 1);
                set.text(0x28, 4, "CS", "MONOCHROME1");
            }));
            CHECK(stored.bits_stored == bits);
        };
        check(std::uint8_t{}, 5);  // 35 bytes of values, and one that makes them even.
        check(std::int8_t{}, 6);
        check(std::uint32_t{}, 20);
        check(std::int32_t{}, 17);
    }

    TEST_CASE("frames that follow each other are one place, others have their own") {
        const TemporaryFolder folder;
        const StoredVolume rising =
            check_same(folder.write("rising.dcm", multi_frame({1, 3, 5, 7, 9}).file()));
        REQUIRE(rising.files.size() == 1);
        CHECK(rising.files[0].slices == 5);
        const StoredVolume falling =
            check_same(folder.write("falling.dcm", multi_frame({9, 7, 5, 3, 1}).file()));
        CHECK(falling.files.size() == 5);
        const StoredVolume mixed =
            check_same(folder.write("mixed.dcm", multi_frame({5, 7, 9, 1, 3}).file()));
        REQUIRE(mixed.files.size() == 2);
        CHECK(mixed.files[0].slices == 2);
        CHECK(mixed.files[1].slices == 3);
        CHECK(mixed.files[0].offset_bytes > mixed.files[1].offset_bytes);
    }

    TEST_CASE("elements after the pixels do not matter, and large series go to the GPs unasked") {
        const TemporaryFolder folder;
        const std::string path = series<std::int16_t>(folder, [](DicomSet& set, int) {
            set.put(0xfffc, 0xfffc, "OB", std::string(10, 'x'));
        });
        check_same(path);
        ImportRequest request = request_for(path, ReadBy::automatic);
        request.host_bytes = 4 * pixels * 2;
        CHECK(!import_volume(request).stored);
        --request.host_bytes;
        CHECK(import_volume(request).stored);
    }

    TEST_CASE("what GPs cannot read is refused with the file, the reason and the remedy") {
        const TemporaryFolder folder;
        const std::string begin = "x.dcm: GPs cannot read the values from this file: ";
        DicomSet packed = slice_at<std::int16_t>(1, 1);
        packed.compressed_pixels("0123456789");
        const std::string compressed =
            refusal(folder.write("x.dcm", packed.file("1.2.840.10008.1.2.4.90")));
        CHECK(has(compressed,
                  begin + "x.dcm is compressed, deflated, big endian, or cut. Load it with"));
        CHECK(has(refusal(folder.write("x.dcm", mosaic().file())),
                  begin + "x.dcm has its slices side by side, as a mosaic"));

        const std::string path = series<std::int16_t>(folder, [](DicomSet& set, int slice) {
            set.number(0x28, 0x101, slice == 2 ? 12 : 16).number(0x28, 0x102, slice == 2 ? 11 : 15);
        });
        CHECK(has(refusal(path),
                  "series: GPs cannot read the values from this folder: its slices have values of "
                  "several types: 3.dcm has 16 of 16 bits, signed, 2.dcm has 12 of 16 bits, "
                  "signed. Load it with read=host"));
        ImportRequest request = request_for(path, ReadBy::gps);
        request.crop_first = request.crop_size = {1, 1, 1};
        CHECK_THROWS_WITH_AS(
            import_volume(request),
            (path + ": GPs cannot read the values from this folder: crop=, resample= and smooth= "
                    "need all values in the io process. Load it with read=host, or write it as an "
                    "uncompressed NRRD, MetaImage or NIfTI file first")
                .c_str(),
            ImportError);
    }

    TEST_CASE("pixels that state fewer bytes than their picture has are not read past their end") {
        const TemporaryFolder folder;
        DicomSet set = slice_at<std::int16_t>(1, 1);
        set.put(0x7fe0, 0x10, "OW", values_of<std::int16_t>(1).substr(0, 40));
        set.put(0xfffc, 0xfffc, "OB", std::string(100, 'x'));
        CHECK(has(refusal(folder.write("x.dcm", set.file())),
                  "x.dcm is compressed, deflated, big endian, or cut"));
    }

    TEST_CASE("a file that changes after its header was read is refused") {
        const TemporaryFolder folder;
        const std::string path = folder.write("x.dcm", multi_frame({1, 3, 5}).file());
        OrderedSeries series = order_series(path, read_dicom_slices(path), request_for(path, {}));
        series.result.volume.stored = stored_volume_of(series.slices);
        CHECK_NOTHROW(scan_values({path, {}, {}, 1000}, series.result.volume));
        series.result.volume.stored = stored_volume_of(series.slices);
        std::ofstream(path, std::ios::app) << "more";
        CHECK_THROWS_WITH_AS(scan_values({path, {}, {}, 1000}, series.result.volume),
                             doctest::Contains("has changed while it was read"), ImportError);
    }

    TEST_CASE("pixels that stand in a file twice are refused") {
        const TemporaryFolder folder;
        const std::string bytes = slice_at<std::int16_t>(1, 1).file();
        const std::string pixels_again = slice_at<std::int16_t>(1, 2).file().substr(
            bytes.size() - 2 * pixels - 12);  // The last element.
        CHECK(
            has(refusal(folder.write("x.dcm", bytes + pixels_again)), "stands in the file twice"));
    }

    TEST_CASE("a GP opens the files of its slices only") {
        const TemporaryFolder folder;
        const std::string path = series<std::int16_t>(folder, unchanged);
        const Volume volume = import_volume(request_for(path, ReadBy::gps));
        fs::remove(path + "/3.dcm");  // Slice 0.
        gp::StoredSlices slices(shape_of(volume), *volume.stored);
        CHECK_NOTHROW(slices.read(2));
        CHECK_NOTHROW(slices.check());
        CHECK_THROWS_AS(slices.read(0), gp::StoredFileError);
    }

    TEST_CASE("a file of the series that has changed is named") {
        const TemporaryFolder folder;
        const std::string path = series<std::int16_t>(folder, unchanged);
        const Volume volume = import_volume(request_for(path, ReadBy::gps));
        gp::StoredSlices slices(shape_of(volume), *volume.stored);
        slices.read(0);
        std::ofstream(path + "/3.dcm", std::ios::app) << "more";  // The file of slice 0.
        std::string error;
        try {
            slices.read(1);
        } catch (const gp::StoredFileError& refused) {
            error = refused.what();
        }
        CHECK(has(error, path + "/3.dcm: its size in bytes is "));
    }
}
