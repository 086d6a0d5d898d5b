// Findings about headers that leave out, or contradict, a fact; and errors that tell the way on.
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

/// The error for `path` without the file's name. Empty if the file is read.
std::string complaint(const std::string& path) {
    try {
        import_volume(path);
    } catch (const ImportError& error) {
        return std::string(error.what()).substr(path.size() + 2);
    }
    return "";
}

Grid cube() {
    Grid grid{{4, 3, 2}, glm::dmat4(1.0), ramp<std::int16_t>(24)};
    return grid;
}

std::string meta_image(const std::string& orientation) {
    return "NDims = 3\nDimSize = 4 3 2\nElementType = MET_UCHAR\nElementSpacing = 1 1 1\n" +
           orientation + "ElementDataFile = LOCAL\n" + std::string(24, 'x');
}

/// Slices in a folder, of which each lies `sideways_mm` beside the one before.
Volume series(const std::string& modality, double sideways_mm) {
    const TemporaryFolder folder;
    Grid grid = cube();
    grid.dims = {4, 3, 3};
    grid.values = ramp<std::int16_t>(36);
    grid.affine[2] = {0, sideways_mm, 1, 0};
    for (int z = 0; z < 3; ++z) {
        folder.write("s" + std::to_string(z),
                     dicom_slice(grid, z).text(8, 0x60, "CS", modality).file());
    }
    return import_volume(folder.file(""));
}

}  // namespace

TEST_SUITE("host/io/header_findings") {
    TEST_CASE("an AnatomicalOrientation of question marks is not stated") {
        const TemporaryFolder folder;
        for (const char* unknown : {"", "AnatomicalOrientation = ???\n"}) {
            CAPTURE(unknown);
            CHECK(reports(import_volume(folder.write("v.mha", meta_image(unknown))),
                          FindingKind::assumption, "states no AnatomicalOrientation"));
        }
        CHECK_FALSE(reports(
            import_volume(folder.write("v.mha", meta_image("AnatomicalOrientation = RAI\n"))),
            FindingKind::assumption, ""));
    }

    TEST_CASE("a tilt is one of CT and from 0.1 degrees on, and other shears are told as shears") {
        CHECK(reports(series("CT", 0.1), FindingKind::gantry_tilt, "meet at 84.29 degrees"));
        CHECK_FALSE(reports(series("CT", 0.0016), FindingKind::gantry_tilt, ""));
        CHECK_FALSE(reports(series("CT", 0.0016), FindingKind::note, "sheared"));
        CHECK(reports(series("CT", 0.0019), FindingKind::gantry_tilt, "meet at 89.89 degrees"));
        const Volume mr = series("MR", 0.1);
        CHECK_FALSE(reports(mr, FindingKind::gantry_tilt, ""));
        CHECK(reports(mr, FindingKind::note, "sheared: the y and z axes meet at 84.29 degrees"));
        CHECK_FALSE(reports(mr, FindingKind::note, "gantry"));
    }

    TEST_CASE("a unit of length that is missing is a note and no assumed place") {
        const TemporaryFolder folder;
        NiftiHeader header = nifti1_header(cube());
        header.put<char>(123, 0);
        const Volume volume =
            import_volume(folder.write("v.nii", header.bytes() + bytes_of(cube().values)));
        CHECK(reports(volume, FindingKind::note, "states no unit of length: read as millimeters"));
        CHECK_FALSE(is_assumed(volume));
        std::string nrrd = nrrd_file(cube());
        nrrd.insert(nrrd.find("space directions"), "space units: \"\" \"\" \"\"\n");
        CHECK_FALSE(is_assumed(import_volume(folder.write("v.nrrd", nrrd))));
        nrrd.replace(nrrd.find("\"\" \"\""), 5, "\"inch\" \"inch\"");
        CHECK(is_assumed(import_volume(folder.write("v.nrrd", nrrd))));
    }

    TEST_CASE("counts that contradict the header or the data are told") {
        const TemporaryFolder folder;
        std::string vtk = vtk_file(cube());
        CHECK_FALSE(reports(import_volume(folder.write("v.vtk", vtk)), FindingKind::note, ""));
        vtk.replace(vtk.find("POINT_DATA 24"), 13, "POINT_DATA 25");
        CHECK(reports(import_volume(folder.write("v.vtk", vtk)), FindingKind::note,
                      "POINT_DATA is 25, DIMENSIONS 4x3x2 have 24 points"));
        NiftiHeader header = nifti1_header(cube());
        header.put<std::int16_t>(72, 8);
        const std::string nifti = header.bytes() + bytes_of(cube().values);
        CHECK(reports(import_volume(folder.write("v.nii", nifti)), FindingKind::note,
                      "bitpix is 8, datatype 4 has 16 bits: the datatype counts"));
        CHECK(reports(import_volume(folder.write(
                          "v.nii.gz", gzipped(folder, nifti1_file(cube())) + "trailing words")),
                      FindingKind::note,
                      "v.nii.gz holds 14 bytes after the end of its compressed data"));
        CHECK_FALSE(
            reports(import_volume(folder.write("w.nii.gz", gzipped(folder, nifti1_file(cube())))),
                    FindingKind::note, "after the end"));
    }

    TEST_CASE("scaled whole numbers are rounded only where float32 cannot tell them apart") {
        const TemporaryFolder folder;
        NiftiHeader header = nifti1_header(cube());
        header.put<float>(112, 0.1F).put<float>(116, 0.3F);
        const Volume tenths =
            import_volume(folder.write("v.nii", header.bytes() + bytes_of(cube().values)));
        CHECK(reports(tenths, FindingKind::conversion, "held as float32, without loss"));
        header.put<std::int16_t>(70, 8).put<std::int16_t>(72, 32).put<float>(116, 0.0F);
        const Volume wide = import_volume(folder.write(
            "v.nii", header.bytes() + bytes_of(std::vector<std::int32_t>(24, (1 << 30) + 1))));
        CHECK(reports(wide, FindingKind::conversion, "24 of 24 are rounded"));
    }

    TEST_CASE("errors of files that are not read say what to do") {
        const TemporaryFolder folder;
        const std::string zeros(24, '\0');
        for (const std::string& bytes : {zeros, gzipped(folder, zeros)}) {
            CHECK(complaint(folder.write("v.bin", bytes)).find("give raw=XxYxZ,TYPE") !=
                  std::string::npos);
        }
        const std::string nrrd =
            "NRRD0004\ntype: short\ndimension: 3\nsizes: 4 3 2\nendian: "
            "little\nencoding: ";
        CHECK(complaint(folder.write("v.nrrd", nrrd + "ascii\n\n1 2 3\n")) ==
              "24 values of short as text need 47 bytes or more, v.nrrd has 6");
        CHECK(complaint(folder.write("v.nrrd", nrrd + "gzip\n\ngarbage"))
                  .find("v.nrrd has 0; its compressed data are broken at byte ") !=
              std::string::npos);
        std::string cut = gzipped(folder, nifti1_file(cube()));
        cut.replace(20, 40, 40, '\xff');
        CHECK(complaint(folder.write("v.nii.gz", cut))
                  .find("its compressed data are broken at byte ") != std::string::npos);
        std::string vtk = vtk_file(cube());
        vtk.replace(vtk.find("short"), 5, "bit");
        CHECK(complaint(folder.write("v.vtk", vtk)) ==
              "SCALARS has values of one bit, which are not read: write them as unsigned_char");
        NiftiHeader header = nifti1_header(cube());
        CHECK(complaint(folder.write("v.nii", header.put<std::int16_t>(70, 128).bytes()))
                  .find("datatype is 128 (RGB color), must be one of the scalar types") == 0);
    }
}
