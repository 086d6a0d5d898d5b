#include <doctest/doctest.h>
#include <fmt/format.h>

#include <string>

#include "host/io/import.hpp"
#include "tests/host/io/volume_files.hpp"

using namespace pxpl5::host::io;
using namespace pxpl5::test;

namespace {

/// The import's error for `path`, without the folder's name. Empty if the file is read.
std::string complaint(const std::string& path) {
    try {
        import_volume(path);
    } catch (const ImportError& error) {
        const std::string folder = path.substr(0, path.rfind('/') + 1);
        std::string text = error.what();
        CHECK_MESSAGE(text.find(path) == 0, "does not begin with the file: ", text);
        for (std::size_t at = text.find(folder); at != std::string::npos; at = text.find(folder)) {
            text.erase(at, folder.size());
        }
        return text;
    }
    return "";
}

const std::string meta_head = "ObjectType = Image\nNDims = 3\n";
const std::string meta_tail = "ElementSpacing = 1 1 1\nElementType = MET_SHORT\n";
const std::string nrrd_head = "NRRD0004\ntype: short\n";
const std::string vtk_head =
    "# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 2 2\n"
    "SPACING 1 1 1\nORIGIN 0 0 0\nPOINT_DATA 8\nSCALARS s float 1\nLOOKUP_TABLE default\n";

}  // namespace

TEST_SUITE("host/io/bad_files") {
    TEST_CASE("a missing file, an empty folder and an unknown suffix are named") {
        const TemporaryFolder folder;
        CHECK(complaint(folder.file("none.nrrd")) == "none.nrrd: No such file or directory");
        folder.write("scan.nii.gz", "");
        CHECK(complaint(folder.file("scan.nii")) ==
              "scan.nii: No such file or directory; did you mean scan.nii.gz?");
        std::filesystem::create_directory(folder.file("series"));
        CHECK(complaint(folder.file("series")) == "series: none of its 0 files is a DICOM image");
        CHECK(complaint(folder.write("x.gif", "abc")).find("x.gif: neither its suffix nor") == 0);
    }

    TEST_CASE("a folder of other files is no series") {
        const TemporaryFolder folder;
        std::filesystem::create_directory(folder.file("series"));
        folder.write("series/a.txt", "hello");
        folder.write("series/b.dcm", std::string(128, '\0') + "DICM");
        CHECK(complaint(folder.file("series")) == "series: none of its 2 files is a DICOM image");
    }

    TEST_CASE("a MetaImage whose raw file is short or absent names both sizes") {
        const TemporaryFolder folder;
        folder.write("v.raw", std::string(4096, 'x'));
        const std::string head = meta_head + "DimSize = 128 128 56\n" + meta_tail;
        CHECK(complaint(folder.write("v.mhd", head + "ElementDataFile = v.raw\n")) ==
              "v.mhd: 128x128x56 of MET_SHORT need 1835008 bytes, v.raw has 4096");
        CHECK(complaint(folder.write("w.mhd", head + "ElementDataFile = w.raw\n")) ==
              "w.mhd: its data file w.raw cannot be read: No such file or directory");
    }

    TEST_CASE("a MetaImage header that lacks or contradicts something is refused") {
        const TemporaryFolder folder;
        const std::string data = "ElementDataFile = LOCAL\n" + std::string(64, 'x');
        CHECK(complaint(folder.write("a.mha", meta_head + meta_tail + data)) ==
              "a.mha: its header has no 'DimSize'");
        CHECK(complaint(folder.write("b.mha", meta_head + "DimSize = 4 4\n" + meta_tail + data)) ==
              "b.mha: NDims is 3, but DimSize has 2 values");
        CHECK(
            complaint(folder.write("c.mha", meta_head + "DimSize = 4 -4 2\n" + meta_tail + data)) ==
            "c.mha: DimSize is '4 -4 2', must be whole numbers");
        CHECK(complaint(folder.write(
                  "d.mha", meta_head + "DimSize = 4 4 2\nElementType = MET_X\n" + data)) ==
              "d.mha: ElementType 'MET_X' is not a scalar type of MetaImage");
        CHECK(complaint(folder.write("e.mha", meta_head + "ElementNumberOfChannels = 3\n" +
                                                  "DimSize = 2 2 2\n" + meta_tail + data)) ==
              "e.mha: ElementNumberOfChannels is 3, a scalar volume has 1");
    }

    TEST_CASE("a pattern of data files that is more than one %d never reaches sprintf") {
        const TemporaryFolder folder;
        const std::string head = meta_head + "DimSize = 4 4 2\n" + meta_tail + "ElementDataFile = ";
        for (const char* pattern : {"%s%s%n 1 2 1", "v%d%d.raw 1 2 1", "v%999d.raw 1 2 1", "v%"}) {
            CAPTURE(pattern);
            CHECK(complaint(folder.write("p.mhd", head + pattern + "\n"))
                      .find("must be LOCAL, LIST, a name, or a pattern with one %d") !=
                  std::string::npos);
            CHECK(complaint(folder.write("p.nhdr", nrrd_head + "dimension: 3\nsizes: 2 2 2\n" +
                                                       "endian: little\nencoding: raw\n" +
                                                       "data file: " + pattern + "\n")) != "");
        }
    }

    TEST_CASE("a compressed MetaImage that is cut is refused") {
        const TemporaryFolder folder;
        const std::string head = meta_head + "CompressedData = True\nDimSize = 16 16 16\n" +
                                 meta_tail + "ElementDataFile = LOCAL\n";
        // The first two bytes are no begin of compressed data.
        CHECK(complaint(folder.write("cut.mha", head + std::string(100, 'x'))) ==
              fmt::format("cut.mha: 16x16x16 of MET_SHORT need 8192 bytes when decompressed, "
                          "cut.mha has 0; its compressed data are broken at byte {} of the file",
                          head.size() + 2));
    }

    TEST_CASE("sizes beyond the limits are refused before anything is allocated") {
        const TemporaryFolder folder;
        const auto nrrd = [&](const std::string& sizes) {
            return complaint(folder.write("n.nrrd", nrrd_head + "dimension: 3\nsizes: " + sizes +
                                                        "\nencoding: raw\nendian: little\n\nxx"));
        };
        CHECK(nrrd("4294967296 4294967296 2") ==
              "n.nrrd: 4294967296 voxels along x, must be 2 to 4096");
        CHECK(nrrd("16 1 16") == "n.nrrd: 1 voxels along y, must be 2 to 4096");
        CHECK(nrrd("4096 4096 4096") ==
              "n.nrrd: 4096x4096x4096 of short need 137438953472 bytes, at most 8589934592 are "
              "read: write a smaller file first, a part or every second voxel (crop= and "
              "resample= work on what was read)");
        CHECK(nrrd("16 16 16") == "n.nrrd: 16x16x16 of short need 8192 bytes, n.nrrd has 2");
    }

    TEST_CASE("a row of values and time series are no volumes") {
        const TemporaryFolder folder;
        CHECK(complaint(folder.write("row.nrrd", nrrd_head +
                                                     "dimension: 1\nsizes: 16\n"
                                                     "encoding: raw\nendian: little\n\n" +
                                                     std::string(32, 'x'))) ==
              "row.nrrd: has 1 axes (16), a volume has 3");
        CHECK(complaint(folder.write("series.nrrd",
                                     nrrd_head +
                                         "dimension: 4\nsizes: 2 2 2 5\nencoding: raw\nendian: "
                                         "little\n\n" +
                                         std::string(80, 'x'))) ==
              "series.nrrd: has 4 axes (2x2x2x5). If it is a time series, select a volume with "
              "frame=N, 1 to 5. Vectors and color are not read");
    }

    TEST_CASE("a color NRRD is refused") {
        const TemporaryFolder folder;
        CHECK(complaint(folder.write(
                  "rgb.nrrd",
                  "NRRD0004\ntype: uchar\ndimension: 4\nsizes: 3 2 2 2\nkinds: RGB-color domain "
                  "domain domain\nencoding: raw\n\n" +
                      std::string(24, 'x'))) ==
              "rgb.nrrd: has 4 axes (3x2x2x2), of which axis 1 is not in space: vectors and color "
              "are not read, and the volumes of a time series must be the last axis");
    }

    TEST_CASE("broken NRRD headers are refused") {
        const TemporaryFolder folder;
        const std::string rest = "dimension: 3\nsizes: 2 2 2\nendian: little\n";
        CHECK(complaint(folder.write("a.nrrd", "MRRD0004\n")) ==
              "a.nrrd: begins with 'MRRD0004', a NRRD file with 'NRRD000'");
        CHECK(complaint(folder.write("b.nrrd", nrrd_head + rest + "encoding: lz77\n\n")) ==
              "b.nrrd: encoding is 'lz77', must be raw, ascii, hex, gzip or bzip2");
        CHECK(complaint(
                  folder.write("c.nrrd", nrrd_head + rest + "encoding: raw\nbyte skip: -5\n\n")) ==
              "c.nrrd: byte skip is -5, must be -1 or more");
        const std::string zipped = nrrd_head + rest + "encoding: gzip\n\n";
        CHECK(complaint(folder.write("d.nrrd", zipped + "garbage")) ==
              fmt::format("d.nrrd: 2x2x2 of short need 16 bytes when decompressed, d.nrrd has 0; "
                          "its compressed data are broken at byte {} of the file",
                          zipped.size() + 2));
        CHECK(complaint(folder.write("e.nhdr",
                                     nrrd_head + rest + "encoding: raw\ndata file: gone.raw\n")) ==
              "e.nhdr: its data file gone.raw cannot be read: No such file or directory");
        CHECK(complaint(
                  folder.write("f.nhdr", nrrd_head + rest + "encoding: raw\ndata file: \f\n")) ==
              "f.nhdr: data file is '?', must be a name, a pattern or LIST");
    }

    TEST_CASE("broken NIfTI headers name the field and its value") {
        const TemporaryFolder folder;
        const std::string data(48, 'x');
        const auto nifti = [&](const NiftiHeader& header) {
            return complaint(folder.write("n.nii", header.bytes() + data));
        };
        CHECK(nifti(NiftiHeader().put<std::int16_t>(40, 9)) ==
              "n.nii: dim[0] is 9, must be 1 to 7");
        CHECK(nifti(NiftiHeader().put<std::int16_t>(44, -3)) ==
              "n.nii: dim[2] is -3, must be 1 or more");
        CHECK(nifti(NiftiHeader().put<std::int16_t>(70, 9999)).find("n.nii: datatype is 9999") ==
              0);
        CHECK(nifti(NiftiHeader().put<float>(80, std::numeric_limits<float>::quiet_NaN())) ==
              "n.nii: pixdim[1] is nan, must be the distance of voxels in millimeters");
        CHECK(nifti(NiftiHeader().put<float>(88, 0.0F)) ==
              "n.nii: pixdim[3] is 0, must be the distance of voxels in millimeters");
        CHECK(nifti(NiftiHeader().put<float>(108, 1e6F)) ==
              "n.nii: 4x3x2 of int16 need 48 bytes, n.nii has 0");
        CHECK(nifti(NiftiHeader().put<float>(108, -1.0F)) ==
              "n.nii: vox_offset is -1, must be 348 or more");
        CHECK(nifti(NiftiHeader().put<std::int32_t>(0, 540)) ==
              "n.nii: its header needs 540 bytes, 400 could be read");
        CHECK(nifti(NiftiHeader().put<char>(345, '?')) ==
              "n.nii: magic is 'n?1', must be 'n+1' or 'n+2'");
        CHECK(complaint(folder.write("s.nii", "short")) ==
              "s.nii: its header needs 348 bytes, 5 could be read");
    }

    TEST_CASE("VTK files that hold words, too few values or no points are refused") {
        const TemporaryFolder folder;
        CHECK(complaint(folder.write("a.vtk", vtk_head + "1 2 three 4 5 6 7 8\n")) ==
              "a.vtk: value 2 is 'three', must be a number");
        CHECK(complaint(folder.write("b.vtk", vtk_head + "1000000000 2 3 4\n")) ==
              "b.vtk: has 4 values, its header states 8");
        std::string mesh = vtk_head;
        mesh.replace(mesh.find("STRUCTURED_POINTS"), 17, "POLYDATA");
        CHECK(complaint(folder.write("c.vtk", mesh)) ==
              "c.vtk: DATASET is 'POLYDATA', must be STRUCTURED_POINTS");
    }

    TEST_CASE("axes that span no volume are refused") {
        const TemporaryFolder folder;
        const std::string text = complaint(folder.write(
            "flat.nrrd",
            "NRRD0004\ntype: uchar\ndimension: 3\nspace: left-posterior-superior\nsizes: 2 2 2\n"
            "space directions: (1,0,0) (1,0,0) (0,0,1)\nencoding: raw\n\n12345678"));
        CHECK(text.find("flat.nrrd: its axes span no volume") == 0);
    }

    TEST_CASE("values beyond float32 are refused, since the volume would hold infinities") {
        const TemporaryFolder folder;
        const auto with_last = [&](double last) {
            std::vector<double> values = {1, 2, 3, 4, 5, 6, 7.5};
            values.push_back(last);
            return complaint(folder.write("d.nrrd",
                                          "NRRD0004\ntype: double\ndimension: 3\nsizes: 2 2 2\n"
                                          "endian: little\nencoding: raw\n\n" +
                                              bytes_of(values)));
        };
        CHECK(with_last(1e39) ==
              "d.nrrd: its values reach from 1 to 1e+39, must be within +-3.40282e+38 (float32)");
        CHECK(with_last(-1e300) ==
              "d.nrrd: its values reach from -1e+300 to 7.5, must be within +-3.40282e+38 "
              "(float32)");
        CHECK(with_last(-double{std::numeric_limits<float>::max()}) == "");
        CHECK(with_last(std::numeric_limits<double>::infinity()) == "");
    }

    TEST_CASE("spacings and places that no machine can draw are refused with their limits") {
        const TemporaryFolder folder;
        const auto placed = [&](const std::string& directions, const std::string& origin) {
            return complaint(folder.write(
                "p.nrrd",
                "NRRD0004\ntype: uchar\ndimension: 3\nspace: left-posterior-superior\n"
                "sizes: 2 2 2\nspace directions: " +
                    directions + "\nspace origin: " + origin + "\nencoding: raw\n\n12345678"));
        };
        const std::string usual = "(1,0,0) (0,1,0) (0,0,1)";
        CHECK(placed("(1,0,0) (0,1e102,0) (0,0,1)", "(0,0,0)") ==
              "p.nrrd: spacing along y is 1e+102 mm, must be 1e-06 to 1000000 mm");
        CHECK(placed("(1,0,0) (0,1,0) (0,0,1e-7)", "(0,0,0)") ==
              "p.nrrd: spacing along z is 1e-07 mm, must be 1e-06 to 1000000 mm");
        CHECK(placed(usual, "(0,-2e7,0)") ==
              "p.nrrd: y of voxel 0,0,0 is -20000000 mm, must be within +-1000000 mm");
        CHECK(placed(usual, "(0,0,1e6)") ==
              "p.nrrd: z of voxel 0,0,1 is 1000001 mm, must be within +-1000000 mm");
        CHECK(placed("(1e6,0,0) (0,1e-6,0) (0,0,1)", "(0,-1e6,0)") == "");
    }
}
