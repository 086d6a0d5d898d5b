// frame=N: one volume of a time series, in each format and encoding that has them.
#include <bzlib.h>
#include <doctest/doctest.h>

#include <algorithm>
#include <fstream>
#include <random>

#include "host/io/formats/stored_header.hpp"
#include "host/io/import.hpp"
#include "tests/host/io/formats/read_frame.hpp"
#include "tests/host/io/volume_writers.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using namespace pxpl5::host::io;
using namespace pxpl5::test;

namespace {

constexpr std::size_t frames = 3, voxels = 24;  // Of 4x3x2 voxels each.

/// Volumes one after the other, none like another.
Grid series() {
    Grid grid{{4, 3, 2}, glm::dmat4(1.0), std::vector<std::int16_t>(frames * voxels)};
    for (std::size_t i = 0; i < grid.values.size(); ++i) {
        grid.values[i] = static_cast<std::int16_t>(1000 * (i / voxels) + i % voxels);
    }
    grid.affine[3] = {10, -20, 30, 1};
    return grid;
}

std::vector<std::int16_t> values_of(std::size_t frame) {
    const std::vector<std::int16_t> all = series().values;
    const auto first = all.begin() + static_cast<std::ptrdiff_t>((frame - 1) * voxels);
    return {first, first + voxels};
}

bool holds(const Volume& volume, const std::vector<std::int16_t>& values) {
    return volume.values.size() == values.size() * 2 &&
           std::memcmp(volume.values.data(), values.data(), volume.values.size()) == 0;
}

/// The error without the file's name; empty if the volume is read.
std::string refusal(const std::string& path, std::uint32_t frame) {
    try {
        read_frame(path, frame);
        return {};
    } catch (const ImportError& error) {
        const std::string text = error.what();
        return text.substr(text.find(": ") + 2);
    }
}

/// Each volume of the series, and no other.
void check_frames(const std::string& path, const std::string& axes = "4x3x2x3") {
    CAPTURE(path);
    if (path.ends_with("nrrd") || path.ends_with("nhdr")) {  // Whose fourth axis may be anything.
        CHECK(refusal(path, 0) ==
              "has 4 axes (" + axes +
                  "). If it is a time series, select a volume with frame=N, 1 to 3. "
                  "Vectors and color are not read");
    } else {
        CHECK(holds(read_frame(path, 0), values_of(1)));
    }
    CHECK(refusal(path, 4) == "frame is 4, but the file has 3 volumes: give frame=1 to 3");
    for (std::size_t frame = 1; frame <= frames; ++frame) {
        CAPTURE(frame);
        const Volume volume = read_frame(path, static_cast<std::uint32_t>(frame));
        CHECK(std::array{volume.nx, volume.ny, volume.nz} == std::array{4, 3, 2});
        CHECK(holds(volume, values_of(frame)));
        CHECK(volume.frame == static_cast<int>(frame));
        CHECK(volume.frames == 3);
        CHECK(volume.voxel_to_patient == series().affine);
        const std::string text = fmt::format("volume {} of 3 of a time series", frame);
        CHECK(std::ranges::count(volume.findings, text, &Finding::text) == 1);
        CHECK(std::ranges::none_of(volume.findings, [](const Finding& finding) {
            return finding.text.find("more") != std::string::npos;  // Bytes than are stated.
        }));
    }
    std::size_t next = 2;
    for (const Volume& volume : read_in_turn(path, 2, frames)) {
        CAPTURE(next);
        CHECK(volume.frame == static_cast<int>(next));
        CHECK(holds(volume, values_of(next++)));
    }
}

/// Bytes that this process has read so far.
std::uint64_t bytes_read() {
    std::ifstream counts("/proc/self/io");
    std::string name;
    std::uint64_t bytes = 0;
    counts >> name >> bytes;
    REQUIRE(name == "rchar:");
    return bytes;
}

std::string bzipped(std::string bytes) {
    std::string out(bytes.size() + 1000, '\0');
    auto size = static_cast<unsigned>(out.size());
    REQUIRE(BZ2_bzBuffToBuffCompress(out.data(), &size, bytes.data(),
                                     static_cast<unsigned>(bytes.size()), 9, 0, 0) == BZ_OK);
    out.resize(size);
    return out;
}

std::string nrrd(const std::string& encoding, const std::string& more = "") {
    return "NRRD0004\ntype: short\ndimension: 4\nspace: LPS\nsizes: 4 3 2 3\nendian: little\n"
           "space directions: (1,0,0) (0,1,0) (0,0,1) none\nspace origin: (10,-20,30)\n"
           "encoding: " +
           encoding + "\n" + more + "\n";
}

std::string nifti() {
    NiftiHeader header = nifti1_header(series());
    header.put_dims({4, 4, 3, 2, 3, 1, 1, 1});
    return header.bytes() + bytes_of(series().values);
}

std::string meta_image(const std::string& rest) {
    return "NDims = 4\nDimSize = 4 3 2 3\nElementType = MET_SHORT\nElementSpacing = 1 1 1 2.5\n"
           "TransformMatrix = 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\nOffset = 10 -20 30 0\n" +
           rest;
}

}  // namespace

TEST_SUITE("host/io/time series") {
    TEST_CASE("NIfTI, compressed or not") {
        const TemporaryFolder folder;
        check_frames(folder.write("v.nii", nifti()));
        check_frames(folder.write("v.nii.gz", gzipped(folder, nifti())));
    }

    TEST_CASE("compressed volumes that are read in turn are decompressed once") {
        const TemporaryFolder folder;
        constexpr std::uint16_t count = 24, side = 64, slices = 8;
        Grid grid = series();
        grid.dims = {side, side, slices};
        grid.values.resize(std::size_t{count} * side * side * slices);
        std::minstd_rand noise(1);
        std::ranges::generate(grid.values, [&] { return static_cast<std::int16_t>(noise()); });
        NiftiHeader header = nifti1_header(grid);
        header.put_dims({4, side, side, slices, count, 1, 1, 1});
        const std::string whole = gzipped(folder, header.bytes() + bytes_of(grid.values));
        REQUIRE(whole.size() > 2 * grid.values.size() * 9 / 10);
        const std::string path = folder.write("v.nii.gz", whole);
        std::uint64_t before = bytes_read();
        const std::vector<Volume> turn = read_in_turn(path, 1, count);
        const std::uint64_t in_turn = bytes_read() - before;
        before = bytes_read();
        for (std::uint32_t frame = 1; frame <= count; ++frame) {
            CHECK(read_frame(path, frame).values == turn[frame - 1].values);
        }
        CHECK(3 * in_turn < bytes_read() - before);
        std::string damaged = whole;
        damaged[damaged.size() - 6] ^= 1;  // In the checksum, which follows the last volume.
        ImportRequest request;
        request.path = folder.write("damaged.nii.gz", damaged);
        Importer importer(request);
        CHECK(importer.read(1, true).values == turn[0].values);
        CHECK(importer.read(3, true).values == turn[2].values);
        CHECK(importer.read(2, true).values == turn[1].values);  // From the beginning again.
        CHECK_THROWS_WITH_AS(importer.read(count), doctest::Contains("the checksum is"),
                             ImportError);
    }

    TEST_CASE("MGH, compressed or not") {
        const TemporaryFolder folder;
        check_frames(folder.write("v.mgh", mgh_file(series(), frames)));
        check_frames(folder.write("v.mgz", gzipped(folder, mgh_file(series(), frames))));
    }

    TEST_CASE("NRRD in five encodings, and with the values as the last bytes of a file") {
        const TemporaryFolder folder;
        const std::string values = bytes_of(series().values);
        std::string hex, ascii;
        for (const char c : values) {
            hex += fmt::format("{:02x}", static_cast<unsigned char>(c));
        }
        for (const std::int16_t value : series().values) {
            ascii += fmt::format("{} ", value);
        }
        check_frames(folder.write("raw.nrrd", nrrd("raw") + values));
        check_frames(folder.write("gzip.nrrd", nrrd("gzip") + gzipped(folder, values)));
        check_frames(folder.write("bzip2.nrrd", nrrd("bzip2") + bzipped(values)));
        check_frames(folder.write("hex.nrrd", nrrd("hex") + hex));
        check_frames(folder.write("ascii.nrrd", nrrd("ascii") + ascii));
        folder.write("end.raw", "any header" + values);
        check_frames(folder.write("end.nhdr", nrrd("raw", "byte skip: -1\ndata file: end.raw\n")));
        folder.write("end.gz", gzipped(folder, "any header" + values));
        check_frames(folder.write("gz.nhdr", nrrd("gzip", "byte skip: -1\ndata file: end.gz\n")));
    }

    TEST_CASE("MetaImage in one file, and in a file for each volume or slice") {
        const TemporaryFolder folder;
        const std::string values = bytes_of(series().values);
        check_frames(folder.write("v.mha", meta_image("ElementDataFile = LOCAL\n") + values));
        for (const std::size_t files : {frames, 2 * frames}) {
            std::string list;
            const std::size_t share = values.size() / files;
            for (std::size_t file = 0; file < files; ++file) {
                list += folder
                            .write(fmt::format("{}of{}.raw", file, files),
                                   values.substr(file * share, share))
                            .substr(folder.file("").size()) +
                        "\n";
            }
            check_frames(folder.write("list.mhd", meta_image("ElementDataFile = LIST\n") + list));
        }
        folder.write("half.raw", values.substr(0, values.size() / 2));
        CHECK(refusal(folder.write("half.mhd",
                                   meta_image("ElementDataFile = LIST\nhalf.raw\nhalf.raw\n")),
                      2) ==
              "has 2 data files for 3 volumes, must have one file, or as many for each volume");
    }

    TEST_CASE("a MetaImage with four axes may have no matrix, and must have all numbers of one") {
        const TemporaryFolder folder;
        std::string header = meta_image("ElementDataFile = LOCAL\n");
        const std::size_t at = header.find("TransformMatrix"), end = header.find("Offset");
        header.erase(at, end - at);
        const std::string values = bytes_of(series().values);
        check_frames(folder.write("none.mha", header + values));
        header.insert(at, "TransformMatrix = 0.8 0.6 0 -0.6 0.8 0 0 0 1\n");
        CHECK(refusal(folder.write("nine.mha", header + values), 1) ==
              "TransformMatrix has 9 numbers, 4 axes need 16");
    }

    TEST_CASE("the GPs read the same volume of an uncompressed file") {
        const TemporaryFolder folder;
        const std::string values = bytes_of(series().values);
        folder.write("end.raw", "any header" + values);
        for (const std::string& path :
             {folder.write("v.nii", nifti()), folder.write("v.nrrd", nrrd("raw") + values),
              folder.write("end.nhdr", nrrd("raw", "byte skip: -1\ndata file: end.raw\n"))}) {
            CAPTURE(path);
            const Volume second = read_frame(path, 2, ReadBy::gps);
            CHECK(holds(second, values_of(2)));
            CHECK(second.frame == 2);
            CHECK(second.frames == 3);
        }
    }

    TEST_CASE("the time between two volumes, if the file states it with its unit") {
        const TemporaryFolder folder;
        const auto nifti_ms = [&](int units, float step) {
            NiftiHeader header = nifti1_header(series());
            header.put_dims({4, 4, 3, 2, 3, 1, 1, 1});
            header.put(123, static_cast<char>(2 | units));
            header.put(92, step);
            return read_frame(folder.write("t.nii", header.bytes() + bytes_of(series().values)), 2)
                .frame_ms;
        };
        CHECK(nifti_ms(8, 2.5F) == 2500);
        CHECK(nifti_ms(16, 40) == 40);
        CHECK(nifti_ms(24, 40'000) == doctest::Approx(40));
        CHECK(nifti_ms(0, 40) == 0);
        CHECK(nifti_ms(8, -1) == 0);
        const auto nrrd_ms = [&](const std::string& more) {
            return read_frame(folder.write("t.nrrd", nrrd("raw", more) + bytes_of(series().values)),
                              0)
                .frame_ms;
        };
        const std::string time = "kinds: space space space time\nspacings: nan nan nan 33\n";
        CHECK(nrrd_ms(time + "units: \"\" \"\" \"\" \"ms\"\n") == 33);
        CHECK(nrrd_ms(time + "units: \"\" \"\" \"\" \"s\"\n") == 33'000);
        CHECK(nrrd_ms(time + "units: \"\" \"\" \"\" \"s\n") == 0);
        CHECK(nrrd_ms(time) == 0);
    }

    TEST_CASE("a NRRD whose first axis is not in space has vectors, whatever frame= says") {
        const TemporaryFolder folder;
        const std::string head =
            "NRRD0004\ntype: short\ndimension: 4\nsizes: 3 4 3 2\nendian: little\nencoding: raw\n";
        const std::string values = bytes_of(series().values);
        const std::string vectors =
            "has 4 axes (3x4x3x2), of which axis 1 is not in space: vectors and color are not "
            "read, and the volumes of a time series must be the last axis";
        CHECK(refusal(
                  folder.write("k.nrrd", head + "kinds: vector domain domain domain\n\n" + values),
                  1) == vectors);
        CHECK(
            refusal(folder.write("d.nrrd", head +
                                               "space: LPS\nspace directions: none (1,0,0) (0,1,0) "
                                               "(0,0,1)\n\n" +
                                               values),
                    1) == vectors);
        CHECK(refusal(folder.write("last.nrrd",
                                   "NRRD0004\ntype: short\ndimension: 4\nsizes: 4 3 2 3\n"
                                   "endian: little\nencoding: raw\nkinds: domain domain domain "
                                   "RGB-color\n\n" +
                                       values),
                      2)
                  .find("has 4 axes (4x3x2x3), of which axis 4 is not in space") == 0);
    }

    TEST_CASE("a volume that is cut off, damaged, or not there is refused") {
        const TemporaryFolder folder;
        const std::string whole = nifti();
        const std::string path = folder.write("v.nii", whole.substr(0, whole.size() - voxels));
        const auto has_end = [](const Volume& volume, const std::string& name, int last) {
            const Finding wanted{
                FindingKind::missing_volumes,
                name + " ends after volume " + std::to_string(last) +
                    " of 3: the file is cut off, and the later volumes cannot be shown. curve and "
                    "cine need to=" +
                    std::to_string(last)};
            return std::ranges::count(volume.findings, wanted) == 1;
        };
        const Volume second = read_frame(path, 2);
        CHECK(holds(second, values_of(2)));
        CHECK(has_end(second, "v.nii", 2));
        CHECK(has_end(read_frame(path, 1), "v.nii", 2));
        CHECK(refusal(path, 3) == "volume 3 of 3 ends after 496 bytes, v.nii has 472");
        const std::string half = gzipped(folder, whole);
        const Volume first =
            read_frame(folder.write("h.nii.gz", half.substr(0, half.size() - 12)), 1);
        CHECK(holds(first, values_of(1)));
        CHECK(has_end(first, "h.nii.gz", 2));
        const std::string third = refusal(folder.file("h.nii.gz"), 3);
        CHECK(third.find("volume 3 of 3: 4x3x2 of int16 need 48 bytes when decompressed, h.nii.gz "
                         "has ") != std::string::npos);
        CHECK(third.find(" of them") != std::string::npos);
        std::string packed = gzipped(folder, whole);
        packed[packed.size() - 5] = static_cast<char>(packed[packed.size() - 5] + 1);
        CHECK(refusal(folder.write("v.nii.gz", packed), 1).find("are damaged: the checksum") !=
              std::string::npos);
        Grid one = series();
        one.values.resize(voxels);
        CHECK(refusal(folder.write("one.nii", nifti1_file(one)), 1).empty());
        CHECK(refusal(folder.write("one.nii", nifti1_file(one)), 2) ==
              "frame is 2, but the file has one volume: load it without frame=");
        CHECK(refusal(folder.write("v.vtk", vtk_file(one)), 2) ==
              "frame is 2, but only DICOM, NIfTI, NRRD, MetaImage and MGH files hold time "
              "series that are read");
        CHECK(refusal("phantom:sphere", 2) ==
              "frame is 2, but the phantom has one volume: load it without frame=");
        CHECK(refusal("phantom:heart", 31) ==
              "frame is 31, but the phantom has 30 volumes: give frame=1 to 30");
        NiftiHeader endless = nifti1_header(one);
        endless.put_dims({4, 4, 3, 2, 32767, 1, 1, 1});
        CHECK(refusal(folder.write("long.nii", endless.bytes()), 32767) ==
              "volume 32767 of 32767 ends after 1573168 bytes, long.nii has 352");
        NiftiHeader vectors = nifti1_header(one);
        vectors.put_dims({5, 4, 3, 2, 1, 3, 1, 1});
        CHECK(refusal(folder.write("vectors.nii", vectors.bytes()), 3).find("has 5 axes") == 0);
        // The sum of both numbers of bytes would be small again.
        CHECK(refusal(folder.write("far.nrrd", nrrd("raw", "byte skip: 18446744073709551568\n") +
                                                   bytes_of(series().values)),
                      2) ==
              "its values begin after 18446744073709551568 bytes, must be at most "
              "9007199254740992");
        const std::string values = bytes_of(series().values);
        folder.write("end.raw", values.substr(0, 100));
        folder.write("end.nhdr", nrrd("raw", "byte skip: -1\ndata file: end.raw\n"));
        for (const ReadBy by : {ReadBy::host, ReadBy::gps}) {
            for (const std::uint32_t frame : {1, 2, 3}) {
                CHECK_THROWS_WITH_AS(
                    read_frame(folder.file("end.nhdr"), frame, by),
                    doctest::Contains("its 3 volumes need 144 bytes, end.raw has 100"),
                    ImportError);
            }
        }
    }
}
