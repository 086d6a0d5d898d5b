// Tests the features of each format in small files written byte by byte.
#include <bzlib.h>
#include <doctest/doctest.h>

#include <algorithm>

#include "host/io/import.hpp"
#include "tests/host/io/volume_writers.hpp"

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

bool holds(const Volume& volume, const std::vector<std::int16_t>& values) {
    return volume.values.size() == values.size() * 2 &&
           std::memcmp(volume.values.data(), values.data(), volume.values.size()) == 0;
}

/// A 4x3x2 grid of spacing 1, 2, 3 whose axes are LPS.
Grid small_grid() {
    Grid grid{{4, 3, 2}, glm::dmat4(1.0), ramp<std::int16_t>(24)};
    for (int axis = 0; axis < 3; ++axis) {
        grid.affine[axis] *= axis + 1;
    }
    grid.affine[3] = {10, -20, 30, 1};
    return grid;
}

std::string bzipped(const std::string& bytes) {
    std::string in = bytes, out(bytes.size() + 1000, '\0');
    auto size = static_cast<unsigned>(out.size());
    REQUIRE(BZ2_bzBuffToBuffCompress(out.data(), &size, in.data(), static_cast<unsigned>(in.size()),
                                     9, 0, 0) == BZ_OK);
    out.resize(size);
    return out;
}

const std::string nrrd_head =
    "NRRD0004\ntype: short\ndimension: 3\nspace: LPS\nsizes: 4 3 2\nendian: little\n"
    "space directions: (1,0,0) (0,1,0) (0,0,1)\n";

ImportRequest request_of(const std::string& path) {
    ImportRequest request;
    request.path = path;
    return request;
}

RawLayout raw_layout() {
    RawLayout layout;
    layout.dims = {4, 3, 2};
    layout.type = "int16";
    return layout;
}

}  // namespace

TEST_SUITE("host/io/formats") {
    TEST_CASE("bzip2, hex, ascii and skipped lines and bytes of a NRRD give the same voxels") {
        const TemporaryFolder folder;
        const std::vector<std::int16_t> values = ramp<std::int16_t>(24);
        const std::string bytes = bytes_of(values);
        std::string hex, ascii;
        for (const char c : bytes) {
            hex += fmt::format("{:02X}{}", static_cast<unsigned char>(c), c % 3 == 0 ? "\n" : "");
        }
        for (const std::int16_t value : values) {
            ascii += fmt::format("{},\n ", value);
        }
        const auto nrrd = [&](const std::string& fields, const std::string& data) {
            return import_volume(folder.write("v.nrrd", nrrd_head + fields + "\n\n" + data));
        };
        CHECK(holds(nrrd("encoding: bzip2", bzipped(bytes)), values));
        CHECK(holds(nrrd("encoding: bz2", bzipped(bytes.substr(0, 20)) + bzipped(bytes.substr(20))),
                    values));
        CHECK(holds(nrrd("encoding: hex", hex), values));
        CHECK(holds(nrrd("encoding: ascii", ascii), values));
        CHECK(holds(nrrd("encoding: raw\nbyte skip: 3", "abc" + bytes), values));
        CHECK(holds(nrrd("encoding: raw\nbyte skip: -1", "any words\n" + bytes), values));
        CHECK(holds(nrrd("encoding: raw\nline skip: 2\nbyte skip: 1", "one\ntwo\nx" + bytes),
                    values));
        CHECK(holds(nrrd("encoding: gzip\nline skip: 1\nbyte skip: 2",
                         "one\n" + gzipped(folder, "ab" + bytes)),
                    values));
        CHECK(holds(nrrd("encoding: gzip\nbyte skip: -1", gzipped(folder, "header" + bytes)),
                    values));
    }

    TEST_CASE("a damaged bzip2 stream, odd hex and numbers beyond the type are refused") {
        const TemporaryFolder folder;
        const std::string bytes = bytes_of(ramp<std::int16_t>(24));
        const auto complaint = [&](const std::string& fields, const std::string& data) {
            try {
                import_volume(folder.write("v.nrrd", nrrd_head + fields + "\n\n" + data));
            } catch (const ImportError& error) {
                return std::string(error.what()).substr(folder.file("v.nrrd: ").size());
            }
            return std::string();
        };
        std::string bad = bzipped(bytes);
        bad[bad.size() / 2] = static_cast<char>(~bad[bad.size() / 2]);
        CHECK(complaint("encoding: bzip2", bad)
                  .find("4x3x2 of short need 48 bytes when decompressed, v.nrrd has 0; its "
                        "compressed data are broken at byte ") == 0);
        CHECK(complaint("encoding: hex", std::string(97, 'g')) ==
              "4x3x2 of short need 48 bytes, v.nrrd has 0");
        CHECK(complaint("encoding: ascii", "70000" + std::string(50, '1')) != "");
        CHECK(complaint("encoding: ascii", "70000 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1") ==
              "value 0 is 70000, which the type short does not hold");
        CHECK(complaint("encoding: raw\nline skip: 9", bytes) ==
              "line skip is 9, but only 0 lines follow");
        CHECK(complaint("encoding: raw\nendian: middle", bytes) ==
              "endian is 'middle', must be little or big");
    }

    TEST_CASE("a NRRD of listed files is read in the order of the list") {
        const TemporaryFolder folder;
        const std::vector<std::int16_t> values = ramp<std::int16_t>(24);
        const std::string bytes = bytes_of(values);
        folder.write("b.raw", bytes.substr(0, 24));
        folder.write("a.raw", bytes.substr(24));
        CHECK(holds(import_volume(folder.write(
                        "v.nhdr", nrrd_head + "encoding: raw\ndata file: LIST\nb.raw\na.raw\n")),
                    values));
        CHECK_THROWS_WITH_AS(
            import_volume(folder.write(
                "w.nhdr", nrrd_head + "encoding: raw\ndata file: LIST\nb.raw\ngone.raw\n")),
            doctest::Contains("gone.raw cannot be read"), ImportError);
    }

    TEST_CASE("spaces and units of a NRRD become LPS millimeters") {
        const TemporaryFolder folder;
        const auto nrrd = [&](const std::string& space) {
            return import_volume(folder.write(
                "v.nrrd", "NRRD0005\ntype: uchar\ndimension: 3\nsizes: 4 3 2\nencoding: raw\n" +
                              space + "\n\n" + std::string(24, 'x')));
        };
        const std::string directions =
            "space directions: (1,2,0) (-2,1,0) (0,0,3)\nspace origin: (5,6,7)\n";
        const Volume ras = nrrd(directions + "space: RAS");
        CHECK(ras.voxel_to_patient[0] == glm::dvec4(-1, -2, 0, 0));
        CHECK(ras.voxel_to_patient[3] == glm::dvec4(-5, -6, 7, 1));
        const Volume las = nrrd(directions + "space: left-anterior-superior");
        CHECK(las.voxel_to_patient[0] == glm::dvec4(1, -2, 0, 0));
        CHECK(las.voxel_to_patient[3] == glm::dvec4(5, -6, 7, 1));
        CHECK(reports(las, FindingKind::reflection, "left-handed"));
        const Volume micro = nrrd(directions + "space: LPS\nspace units: \"um\" \"um\" \"um\"");
        CHECK(micro.voxel_to_patient[2].z == doctest::Approx(0.003));
        CHECK(reports(micro, FindingKind::conversion, "lengths in um"));
        const Volume other = nrrd("spacings: 1 2 nan\nspace: 3D-right-handed");
        CHECK(other.voxel_to_patient[1].y == 2);
        CHECK(reports(other, FindingKind::assumption, "no patient space"));
        CHECK(reports(other, FindingKind::assumption, "spacing along z: 1 mm is assumed"));
    }

    TEST_CASE("axes of size 1 outside space are dropped from a NRRD, others are refused") {
        const TemporaryFolder folder;
        const std::string head =
            "NRRD0005\ntype: uchar\ndimension: 4\nspace: LPS\n"
            "space directions: none (1,0,0) (0,1,0) (0,0,2)\nencoding: raw\n";
        const Volume volume = import_volume(
            folder.write("v.nrrd", head + "sizes: 1 4 3 2\n\n" + std::string(24, 'x')));
        CHECK(std::array{volume.nx, volume.ny, volume.nz} == std::array{4, 3, 2});
        CHECK(volume.voxel_to_patient[2].z == 2);
        CHECK_THROWS_WITH_AS(import_volume(folder.write(
                                 "w.nrrd", head + "sizes: 3 4 3 2\n\n" + std::string(72, 'x'))),
                             doctest::Contains("has 4 axes (3x4x3x2)"), ImportError);
    }

    TEST_CASE("a sheared sform keeps its shear") {
        const TemporaryFolder folder;
        Grid grid = small_grid();
        grid.affine[2] = {0, 1.5, 2.0, 0};
        const Volume volume = import_volume(folder.write("v.nii", nifti1_file(grid)));
        CHECK(volume.voxel_to_patient[2].y == doctest::Approx(1.5));
        CHECK(volume.voxel_to_patient[2].z == doctest::Approx(2.0));
        CHECK(holds(volume, grid.values));
        // cos = 3/5 between y and z.
        CHECK(reports(volume, FindingKind::note, "the y and z axes meet at 53.13 degrees"));
    }

    TEST_CASE("a NIfTI-2 is read in big endian, with slope and intercept in double") {
        const TemporaryFolder folder;
        const Grid grid = small_grid();
        std::string file = nifti2_file(grid);
        const Volume volume = import_volume(folder.write("v.nii", file));
        CHECK(holds(volume, grid.values));
        CHECK(volume.voxel_to_patient[2].z == doctest::Approx(3));
        CHECK(volume.findings.empty());
        file.replace(176, 8, bytes_of(0.5, true));
        file.replace(184, 8, bytes_of(0.25, true));
        const Volume scaled = import_volume(folder.write("s.nii", file));
        CHECK(scaled.maximum == 32767 * 0.5 + 0.25);
        CHECK_THROWS_WITH_AS(import_volume(folder.write("c.nii", file.substr(0, 500))),
                             doctest::Contains("its header needs 540 bytes, 500 could be read"),
                             ImportError);
    }

    TEST_CASE(
        "pairs are found from either name, compressed or not, and extensions are passed over") {
        const TemporaryFolder folder;
        const Grid grid = small_grid();
        NiftiHeader header = nifti1_header(grid);
        header.put<char>(345, 'i').put<float>(108, 0.0F);
        folder.write("p.hdr", header.bytes());
        folder.write("p.img", bytes_of(grid.values));
        folder.write("q.hdr.gz", gzipped(folder, header.bytes()));
        folder.write("q.img.gz", gzipped(folder, bytes_of(grid.values)));
        for (const char* name : {"p.hdr", "p.img", "q.hdr.gz", "q.img.gz"}) {
            CAPTURE(name);
            CHECK(holds(import_volume(folder.file(name)), grid.values));
        }
        NiftiHeader extended = nifti1_header(grid);
        extended.put<float>(108, 352.0F + 32);
        CHECK(holds(import_volume(folder.write(
                        "x.nii", extended.bytes() + std::string(32, 'e') + bytes_of(grid.values))),
                    grid.values));
    }

    TEST_CASE("a NIfTI's unit of length counts") {
        const TemporaryFolder folder;
        NiftiHeader header = nifti1_header(small_grid());
        header.put<char>(123, 3);
        const Volume volume =
            import_volume(folder.write("v.nii", header.bytes() + bytes_of(small_grid().values)));
        CHECK(volume.voxel_to_patient[2].z == doctest::Approx(0.003));
        CHECK(volume.voxel_to_patient[3].z == doctest::Approx(0.030));
        CHECK(reports(volume, FindingKind::conversion, "micrometers"));
    }

    TEST_CASE("fourth axes of size 1 are no time series") {
        const TemporaryFolder folder;
        NiftiHeader header = nifti1_header(small_grid());
        header.put_dims({5, 4, 3, 2, 1, 1, 1, 1});
        CHECK(import_volume(folder.write("v.nii", header.bytes() + bytes_of(small_grid().values)))
                  .nz == 2);
    }

    TEST_CASE("a MetaImage of listed files, with a header to skip and a slope, is read") {
        const TemporaryFolder folder;
        folder.write("a.raw", "12" + std::string(12, '\1'));
        folder.write("b.raw", "34" + std::string(12, '\2'));
        const Volume volume = import_volume(folder.write(
            "v.mhd",
            "NDims = 3\nDimSize = 4 3 2\nElementType = MET_UCHAR\nElementSpacing = 1 1 1\n"
            "HeaderSize = -1\nElementToIntensityFunctionSlope = 2\nElementDataFile = LIST\n"
            "a.raw\nb.raw\n"));
        CHECK(volume.type == Scalar::int16);
        CHECK(volume.minimum == 2);
        CHECK(volume.maximum == 4);
    }

    TEST_CASE("a raw file is read as it is described, if its size fits exactly") {
        const TemporaryFolder folder;
        const std::vector<std::int16_t> values = ramp<std::int16_t>(24);
        ImportRequest request =
            request_of(folder.write("v.bin", "header" + bytes_of(values, true)));
        request.raw = raw_layout();
        request.raw->big_endian = true;
        request.raw->offset_bytes = 6;
        CHECK_THROWS_WITH_AS(import_volume(request), doctest::Contains("give spacing=x,y,z"),
                             ImportError);
        request.spacing_mm = glm::dvec3(0.5, 1, 2);
        const Volume volume = import_volume(request);
        CHECK(holds(volume, values));
        CHECK(volume.voxel_to_patient[2].z == 2);
        CHECK(reports(volume, FindingKind::assumption, "no patient space"));
        request.raw->offset_bytes = 4;
        CHECK_THROWS_WITH_AS(
            import_volume(request),
            doctest::Contains("4x3x2 of int16 after 4 bytes need a file of 52 bytes, it has 54"),
            ImportError);
        request.raw->type = "int12";
        CHECK_THROWS_WITH_AS(import_volume(request), doctest::Contains("type 'int12' must be"),
                             ImportError);
    }

    TEST_CASE("each of the 48 orientations puts a raw file's axes along its letters") {
        const TemporaryFolder folder;
        ImportRequest request = request_of(folder.write("v.bin", bytes_of(ramp<std::int16_t>(24))));
        request.raw = raw_layout();
        request.spacing_mm = glm::dvec3(0.5, 1, 2);
        const std::string sides = "LPSRAI";
        int valid = 0;
        for (int code = 0; code < 216; ++code) {
            const std::array<int, 3> at = {code % 6, code / 6 % 6, code / 36};
            for (std::size_t i = 0; i < 3; ++i) {
                request.orientation += sides[static_cast<std::size_t>(at[i])];
            }
            CAPTURE(request.orientation);
            const bool is_valid =
                at[0] % 3 != at[1] % 3 && at[1] % 3 != at[2] % 3 && at[0] % 3 != at[2] % 3;
            if (is_valid) {
                ++valid;
                const Volume volume = import_volume(request);
                for (int i = 0; i < 3; ++i) {
                    glm::dvec3 wanted(0);
                    const int side = at[static_cast<std::size_t>(i)];
                    wanted[side % 3] = (side < 3 ? 1 : -1) * (*request.spacing_mm)[i];
                    CHECK(glm::dvec3(volume.voxel_to_patient[i]) == wanted);
                }
                CHECK(reports(volume, FindingKind::assumption, "point to " + request.orientation));
                CHECK(reports(volume, FindingKind::assumption, "origin=X,Y,Z sets its place"));
                CHECK(!reports(volume, FindingKind::assumption, "no patient space"));
            } else {
                CHECK_THROWS_WITH_AS(import_volume(request), doctest::Contains("one of L and R"),
                                     ImportError);
            }
            request.orientation.clear();
        }
        CHECK(valid == 48);
        for (const char* wrong : {"RA", "RAIS", "rai"}) {
            request.orientation = wrong;
            CHECK_THROWS_WITH_AS(import_volume(request), doctest::Contains(wrong), ImportError);
        }
    }

    TEST_CASE("origin= places the first voxel, and VTK's ORIGIN turns with its axes") {
        const TemporaryFolder folder;
        ImportRequest request = request_of(folder.write("v.bin", bytes_of(ramp<std::int16_t>(24))));
        request.raw = raw_layout();
        request.spacing_mm = glm::dvec3(1, 1, 1);
        request.origin_mm = glm::dvec3(-100, 50.5, 7);
        const Volume placed = import_volume(request);
        CHECK(glm::dvec3(placed.voxel_to_patient[3]) == *request.origin_mm);
        CHECK(reports(placed, FindingKind::assumption, "first voxel is at -100, 50.5, 7 mm"));
        request = request_of(
            folder.write("v.vtk",
                         "# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_POINTS\n"
                         "DIMENSIONS 2 2 2\nSPACING 1 2 3\nORIGIN 10 20 30\nPOINT_DATA 8\n"
                         "SCALARS s short 1\nLOOKUP_TABLE default\n1 2 3 4 5 6 7 8\n"));
        request.orientation = "RAS";
        const Volume turned = import_volume(request);
        CHECK(glm::dvec3(turned.voxel_to_patient[3]) == glm::dvec3(-10, -20, 30));
        CHECK(turned.voxel_to_patient[1].y == -2);
    }

    TEST_CASE("a file that states its place takes no orientation") {
        const TemporaryFolder folder;
        ImportRequest request = request_of(folder.write("v.nii", nifti1_file(small_grid())));
        request.orientation = "RAI";
        CHECK_THROWS_WITH_AS(import_volume(request), doctest::Contains("states its place"),
                             ImportError);
        request.orientation.clear();
        request.origin_mm = glm::dvec3(0);
        CHECK_THROWS_WITH_AS(import_volume(request), doctest::Contains("states its place"),
                             ImportError);
    }

    TEST_CASE("spacing can be given only to files that state none") {
        const TemporaryFolder folder;
        ImportRequest request = request_of(folder.write("v.nii", nifti1_file(small_grid())));
        request.spacing_mm = glm::dvec3(1, 1, 1);
        CHECK_THROWS_WITH_AS(import_volume(request),
                             doctest::Contains("states its spacing (1 x 2 x 3 mm)"), ImportError);
        request.path = folder.write("bare.mha",
                                    "NDims = 3\nDimSize = 4 3 2\nElementType = MET_UCHAR\n"
                                    "ElementDataFile = LOCAL\n" +
                                        std::string(24, 'x'));
        request.spacing_mm = glm::dvec3(1, 2, 5);
        CHECK(import_volume(request).voxel_to_patient[2].z == 5);
        request.spacing_mm = glm::dvec3(1, 0, 5);
        CHECK_THROWS_WITH_AS(import_volume(request), doctest::Contains("spacing along y is 0"),
                             ImportError);
    }

    TEST_CASE("a phantom is imported by its name, and an unknown one is refused") {
        const Volume volume = import_volume("phantom:letters");
        CHECK(std::array{volume.nx, volume.ny, volume.nz} == std::array{84, 48, 72});
        CHECK(volume.name == "phantom:letters");
        CHECK_THROWS_WITH_AS(import_volume("phantom:leters"), doctest::Contains("phantom:letters"),
                             ImportError);
    }
}
